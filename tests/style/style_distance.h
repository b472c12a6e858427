#pragma once

#include <fresco/image.h>

#include <vector>

/// \file How alike two pictures are in style and in content, by measures that no optimiser here uses.

namespace style_test
{

/// Statistics of a picture at three scales: mean and covariance of the colour channels, and the spread of the response to each
/// 5x5 cosine filter on luminance and two colour differences. Pixels whose `mask` is 0 (may be empty) do not take part.
std::vector<double> statistics(const fresco::Raster8& rgb, const fresco::Raster8& mask);

/// Mean absolute difference of two sets of statistics.
double distance(const std::vector<double>& a, const std::vector<double>& b);

/// Signed correlation of the luminance gradients of two pictures of one size, after a Gaussian of 3 px, inside the mask.
double gradient_correlation(const fresco::Raster8& a, const fresco::Raster8& b, const fresco::Raster8& mask);

}  // namespace style_test
