#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

namespace fresco
{

/// CIE L*a*b* (D65, 2 degrees) of displayed sRGB: L* in 0..100. RGB in [0,1]; values outside are clamped. IEC 61966-2-1 and
/// CIE 15.
Vec3f lab_from_rgb(Vec3f rgb);
/// The way back; colors outside the gamut are clamped to [0,1].
Vec3f rgb_from_lab(Vec3f lab);

/// Every pixel of an 8-bit RGB picture: H x W x 3.
RasterF lab_picture(const Raster8& rgb);

}  // namespace fresco
