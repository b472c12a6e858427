#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>

namespace fresco::optimize
{

/// S x S x 3 of colored noise: the sum of five octaves with cells of 4 to 64 texels, each interpolated between random corners,
/// about `mean` with `deviation` in each channel on its own; clamped to [0,1]. The same bytes on every machine, for any number of
/// threads.
RasterF noise_picture(int size_px, Vec3d mean, Vec3d deviation, std::uint64_t seed, int threads);

}  // namespace fresco::optimize
