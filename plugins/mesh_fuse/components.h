#pragma once

#include <fresco/mesh.h>

#include <cstddef>

namespace fuse
{

/// Removes the components (faces connected through vertices) that have less area than that, and vertices without faces. Returns
/// how many components went. Keeps the order of the rest. The mesh has positions and triangles only.
std::size_t remove_small_components(double min_area_m2, fresco::Mesh& mesh);

}  // namespace fuse
