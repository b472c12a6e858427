#pragma once

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <cstddef>

/// Options of `decimated`.
struct DecimateOptions
{
    std::size_t max_faces;             ///< Stop at this many triangles.
    std::size_t piece_faces = 32'768;  ///< Of a piece, at most; at least 64.
};

/// Simplifies a manifold mesh (see fresco/geometry/repair.h) by collapsing edges into the points that change the present surface
/// least (see quadratic.h), cheapest first.
/// The mesh is cut into compact pieces whose shared vertices rest; pieces collapse side by side up to a price that is common to
/// all and rises in steps, then the rest is done with other cuts. Colors are means weighted by the area they stand for. A
/// component never vanishes, so a small target may not be reached: the caller compares. The same result for any number of
/// threads. Needs about 160 bytes per face in addition to the input. Throws Canceled.
fresco::Mesh decimated(const fresco::Mesh& mesh, const DecimateOptions& options, fresco::Progress& progress);
