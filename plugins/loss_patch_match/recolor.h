#pragma once

#include <fresco/images/lab.h>

#include <torch/types.h>

namespace patch_match
{

/// The colors of `picture`: 3 x H x W, any float type, on any device.
fresco::ColorMoments color_moments(const torch::Tensor& picture);

/// `picture` (3 x H x W) with each color mapped and clamped to [0,1]; the same type and device.
torch::Tensor recolored(const torch::Tensor& picture, const fresco::ColorMap& map);

}  // namespace patch_match
