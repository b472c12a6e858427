#pragma once

#include <fresco/texture.h>

/// \file A mesh with fewer faces that looks alike from where a picture is taken.

namespace fresco::rendering
{

/// Leaves out vertices that lie within about `error_m` of the surface between others: edge collapse by meshoptimizer, which keeps
/// borders and the seams between charts. Corners that stay have their texcoords. Without meshoptimizer, all stays as it is. The
/// mesh must have passed check_mesh and have texcoords.
TexturedMesh simplified(const TexturedMesh& textured, double error_m);

/// The meshoptimizer behind simplified(), or "none".
const char* meshoptimizer_version();

}  // namespace fresco::rendering
