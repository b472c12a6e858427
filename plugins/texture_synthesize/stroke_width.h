#pragma once

#include <fresco/image.h>
#include <fresco/progress.h>

namespace fresco::synthesize
{

/// How wide the brush strokes of a picture are, in its pixels: 1.5 times the width at half height, along its minor axis, of the
/// autocorrelation of luminance without what is broader than an eighth of the picture. (Of stripes that is half a period: the
/// width of one.) At least 2. RGB. The same for any number of threads. Throws Cancelled.
double stroke_width_px(const Raster8& rgb, const Progress& progress);

}  // namespace fresco::synthesize
