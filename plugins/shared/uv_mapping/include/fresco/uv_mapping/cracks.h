#pragma once

#include <fresco/image.h>

namespace fresco
{

/// How far behind all its neighbors a pixel lies that was seen through a crack of the mesh.
inline constexpr float crack_depth_m = 0.05F;

/// Whether the pixel lies more than crack_depth_m behind each of its eight neighbors. `met`: H x W, the depth of what each
/// pixel's ray meets first, whichever side of whatever it is; infinity where it meets nothing. A pixel at the border of the
/// picture has no eight neighbors, one that met nothing lies behind nothing: false.
bool seen_through_crack(const RasterF& met, int x, int y);

}  // namespace fresco
