#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>

/// \file The algorithm of the stage.

/// Options of `decimated`.
struct DecimateOptions
{
    std::size_t max_faces;             ///< Stop at this many triangles.
    std::size_t piece_faces = 32'768;  ///< Maximum faces of a piece; at least 64.
};

/// Simplifies a manifold mesh (see fresco/geometry/repair.h) by collapsing edges into the points that change the current surface
/// least (see collapse.h), cheapest first.
/// The mesh is cut into compact pieces with fixed common vertices. Pieces collapse in parallel up to a common price that rises in
/// steps; then the mesh is cut along other lines for the rest. Colors are means weighted by area. A component never vanishes, so
/// a small target may not be reached: the caller must compare. The same result for any number of threads. Needs about 160 bytes
/// per face in addition to the input. Throws Canceled.
fresco::Mesh decimated(const fresco::Mesh& mesh, const DecimateOptions& options, fresco::Progress& progress);
