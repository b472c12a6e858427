#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>

/// \file Closes small holes of a scanned surface.

struct HoleFigures
{
    std::size_t closed = 0;
    std::size_t too_large = 0;  ///< Loops wider than the limit: where the scan ends, above all.
    std::size_t outer = 0;      ///< Loops around a small piece of surface, which are no holes.
    std::size_t failed = 0;     ///< Loops that no surface without self-intersection fills, and those at edges of many faces.
    std::size_t faces_added = 0;
    double area_m2 = 0;  ///< Of the faces added.
};

/// The mesh with every hole closed whose boundary loop has no two vertices farther apart than `max_width_m`. A patch has the
/// least area and dihedral angles (Barequet and Sharir, "Filling gaps in the boundary of a polyhedron", 1995), is refined to the
/// density of its loop, and bends on as the surface around does (Liepa, "Filling holes in meshes", 2003); a flat hole stays flat.
/// New vertices are colored by those of the loop, the nearest most. Vertices and faces of the input keep their numbers;
/// texcoords and charts are dropped. The mesh must have passed check_mesh. The result does not depend on progress.threads().
fresco::Mesh with_holes_closed(const fresco::Mesh& mesh, double max_width_m, fresco::Progress& progress, HoleFigures& figures);
