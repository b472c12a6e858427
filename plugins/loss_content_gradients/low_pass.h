#pragma once

#include <torch/types.h>

namespace content_gradients
{

/// A picture averaged over cells of size x size pixels, as far as a mask lets it count.
struct Cells
{
    torch::Tensor values;  ///< C x h x w, h = floor(H / size): the mean over the cell's valid pixels; 0 where not valid.
    torch::Tensor valid;   ///< h x w, of the picture's type: 1 where at least half of the cell's pixels are valid, else 0.
};

/// `picture` C x H x W, differentiable; `mask` H x W, bool. Empty cells (h or w 0) where a side is shorter than `size`.
Cells low_pass(const torch::Tensor& picture, const torch::Tensor& mask, int size);

/// Luminance (Rec. 709 weights) of RGB: 1 x H x W of 3 x H x W.
torch::Tensor luminance(const torch::Tensor& rgb);

/// Mean square difference over valid cells and channels. Where no cell is valid: the empty tensor, or on another device than the
/// CPU perhaps 0.
torch::Tensor value_difference(const Cells& a, const Cells& b);

/// Mean square difference of the steps between horizontal and between vertical neighbours, both valid; where there are
/// none as value_difference.
torch::Tensor step_difference(const Cells& a, const Cells& b);

}  // namespace content_gradients
