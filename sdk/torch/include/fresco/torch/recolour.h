#pragma once

#include <fresco/recolor.h>

#include <torch/types.h>

namespace fresco
{

/// The colours of a picture: 3 x H x W or 3 x N, any float type, on any device; with `mask` (bool, the picture's shape less its
/// first dimension) only where it is true.
ColorMoments color_moments(const torch::Tensor& picture, const torch::Tensor& mask = {});

/// `picture` (3 x H x W or 3 x N) with each colour mapped and clamped to [0,1]; the same type and device.
torch::Tensor recoloured(const torch::Tensor& picture, const ColorMap& map);

}  // namespace fresco
