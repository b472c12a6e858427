#pragma once

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>

/// Simplifies a manifold mesh (see fresco/geometry/repair.h) to at most `max_faces` by collapsing edges onto one of their ends in
/// the order of the quadric error (Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997;
/// borders held by planes perpendicular to their faces, section 6). No collapse turns a face by more than 90 degrees. Vertices of
/// the result are vertices of the input, in their order; colors are means weighted by the area they stand for. Every component
/// keeps at least one face (four if closed), so a small target may not be reached: the caller compares. One thread; the same
/// input gives the same result. Throws Canceled, and Error if the mesh is not manifold.
fresco::Mesh decimated_openmesh(const fresco::Mesh& mesh, std::size_t max_faces, fresco::Progress& progress);
