#pragma once

#include <fresco/image.h>

/// How much of the camera picture's edges a view keeps: the correlation of the gradients of L*, x and y together, at 256 px
/// height after a Gaussian of 3 px, over covered pixels with only covered ones within 7 px. Uncovered pixels have no weight in
/// the blur. `view`: 3 or 4 channels; `covered`: its covered_pixels; `camera`: RGB of any size and of the view's aspect ratio.
/// NaN where fewer than 1000 pixels are left or one of the two has no gradient.
double edge_correlation(const fresco::Raster8& view, const fresco::Raster8& covered, const fresco::Raster8& camera);
