#pragma once

#include "covisible.h"

#include <fresco/image.h>

#include <vector>

/// The printed figure of a pair of RGB pictures: the mean over matches and channels of |source - target| on the scale 0..1
/// (paper), or of its square on the scale 0..255 (released). NaN without matches.
double reprojection_difference(const fresco::Raster8& source, const fresco::Raster8& target, const std::vector<Match>& matches,
                               Protocol protocol);

/// The same measure of the source picture against itself moved by one pixel: the mean over matches, channels and the two forward
/// differences (to the right, downwards) that exist. What a picture without detail has nothing of. NaN without matches.
double forward_difference(const fresco::Raster8& source, const std::vector<Match>& matches, Protocol protocol);

/// Variance of the 4-neighbor Laplacian of the gray picture (0.299 R + 0.587 G + 0.114 B, 0..255) over the matches that are not
/// at the picture's border. NaN without any.
double sharpness(const fresco::Raster8& source, const std::vector<Match>& matches);
