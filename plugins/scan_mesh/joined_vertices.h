#pragma once

#include <fresco/mesh.h>

#include <cstddef>

namespace scan_mesh
{

/// Joins vertices at one position with one color, which formats with a texcoord per vertex hold apart, so that faces that meet
/// there share them again. A face that would repeat another one then (the back of a wall without thickness) keeps its own
/// vertices. Faces that would name a vertex twice do too. Returns how many vertices are left out; texcoords stay.
std::size_t join_vertices(fresco::Mesh& mesh);

}  // namespace scan_mesh
