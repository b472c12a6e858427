#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file Closes small holes of a scanned surface.

struct HoleFigures
{
    std::size_t closed = 0;
    std::size_t openings = 0;   ///< Cameras looked through: between the slats of a chair, through a handle.
    std::size_t too_large = 0;  ///< Loops wider than the limit: where the scan ends, above all.
    std::size_t outer = 0;      ///< Loops around a small piece of surface, which are no holes.
    std::size_t failed = 0;     ///< Loops that no surface without self-intersection fills, and those at edges of many faces.
    std::size_t faces_added = 0;
    double area_m2 = 0;  ///< Area of the faces added.
};

/// Patch that may fill one hole.
struct HolePatch
{
    std::vector<std::uint32_t> loop;      ///< Vertices of the mesh around the hole, as the faces run.
    std::vector<fresco::Vec3d> added;     ///< New vertices, in the world.
    std::vector<fresco::Triangle> faces;  ///< Into `loop`, and behind it into `added`.
    std::vector<fresco::Vec3d> points;    ///< Some middles of faces, where looks are judged.
    std::size_t looks_through = 0;        ///< Cameras' pixels at these points that measured surface behind them, …
    std::size_t looks_onto = 0;           ///< … or where they lie.

    /// Whether cameras that could see it saw what lies behind it.
    bool is_opening() const;
};

/// A patch for every hole whose boundary loop has no two vertices farther apart than `max_width_m`. It has the least area and
/// dihedral angles (Barequet and Sharir, "Filling gaps in the boundary of a polyhedron", 1995), is refined to the density of its
/// loop, and bends on as the surface around does (Liepa, "Filling holes in meshes", 2003); a flat hole stays flat. The mesh must
/// have passed check_mesh. The result does not depend on progress.threads().
std::vector<HolePatch> hole_patches(const fresco::Mesh& mesh, double max_width_m, fresco::Progress& progress,
                                    HoleFigures& figures);

/// Adds what a view's measured depth (meters along the optical axis, 0: none) says of the patches.
void judge(std::span<HolePatch> patches, const fresco::Camera& camera, const fresco::RasterF& depth_m);

/// The mesh with all patches but openings. New vertices are colored by those of the loop, the nearest most. Vertices and faces of
/// the mesh keep their numbers; texcoords and charts are dropped.
fresco::Mesh with_patches(const fresco::Mesh& mesh, std::span<const HolePatch> patches, HoleFigures& figures);
