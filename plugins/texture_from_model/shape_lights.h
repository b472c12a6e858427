#pragma once

#include <fresco/mesh.h>

#include <vector>

namespace from_model
{

/// Shades a mesh by its shape: 3F linear lights, one per corner. A lamp stands aslant above the mesh, one mesh away from its
/// middle; lightness goes with the angle to it all the way to the back, so that sides that meet differ and large sides are no
/// flat tone. Convex places are a little lighter, concave ones darker. Corner normals are those of the faces around within 40
/// degrees, so edges stay sharp. L* lies between 20 and 90.
std::vector<float> shape_lights(const fresco::Mesh& mesh);

}  // namespace from_model
