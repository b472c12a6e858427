#pragma once

#include <fresco/mesh.h>

#include <cstddef>

namespace my_plugin
{

/// `mesh` scaled by `factor` about the middle of its bounding box. Texcoords, colors and the order of everything stay.
fresco::Mesh scaled(fresco::Mesh mesh, double factor);

}  // namespace my_plugin
