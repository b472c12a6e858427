#pragma once

#include <fresco/image.h>
#include <fresco/parallel.h>

namespace fresco
{

/// How wide the brush strokes of a picture are, in its pixels; what "stroke_cm" is the size of on the surface. 1.5 times the
/// width at half height, along its minor axis, of the autocorrelation of L* without what is broader than an eighth of the
/// picture. Of stripes as soft as a sine that is half a wavelength; of hard-edged ones three eighths of it. At least 2. RGB. The
/// same for any number of threads. Throws Canceled.
double stroke_width_px(const Raster8& rgb, const Progress& progress);

}  // namespace fresco
