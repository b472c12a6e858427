#pragma once

/// \file The way from the losses' gradient of a displayed picture back to the texels that it shows. For evaluation.cpp.

#include "pictures.h"

#include <torch/types.h>

namespace fresco::optimize
{

/// A picture as it is displayed, 3 x H x W, and how far its values lie outside of the displayable range, with their sign;
/// undefined where the picture is not clamped.
struct DisplayedValues
{
    torch::Tensor picture;
    torch::Tensor beyond;
};
/// The displayed values of `stored` (3 x H x W): 0 where `hidden` (H x W, bool). On any device, as a few operators.
DisplayedValues displayed_values(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& hidden);
/// The derivative of the above: `gradient` (3 x H x W, d loss / d displayed) times `factor` (H x W) to d loss / d stored. Inside
/// the displayable range all of it passes; outside only where a step against the gradient leads back, so that no texel is stuck
/// `beyond` the range.
torch::Tensor values_back(const ValueSpace& space, const torch::Tensor& beyond, const torch::Tensor& factor,
                          const torch::Tensor& gradient);

}  // namespace fresco::optimize
