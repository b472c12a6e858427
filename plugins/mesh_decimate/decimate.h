#pragma once

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <cstddef>

/// Options of `decimated`.
struct DecimateOptions
{
    std::size_t max_faces = 500'000;  ///< Stop at this many triangles.
    double max_turn_deg = 90;         ///< No collapse may turn a face further than this.
};

/// Simplifies a manifold mesh (see repair.h) by collapsing edges onto one of their ends in the order of the quadric error
/// (Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997; borders held by planes
/// perpendicular to their faces, section 6). Vertices of the result are vertices of the input, in their order; colours are means
/// weighted by the area they stand for. Every component keeps at least one face (four if closed), so a small target may not be
/// reached: the caller compares. One thread; the same input gives the same result. Throws Cancelled, and Error if the mesh is not
/// manifold.
fresco::Mesh decimated(const fresco::Mesh& mesh, const DecimateOptions& options, fresco::Progress& progress);
