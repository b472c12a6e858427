#include "low_pass.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

namespace content_gradients
{
namespace
{

torch::Tensor averaged(const torch::Tensor& maps, int size)
{
    return at::avg_pool2d(maps.unsqueeze(0), {size, size}).squeeze(0);
}

/// Σ weight · (a - b)² over all channels, and how many squares took part.
struct Squares
{
    torch::Tensor sum;
    torch::Tensor count;

    void add(const torch::Tensor& difference, const torch::Tensor& weight)
    {
        const auto cells = fresco::ordered_sum(weight);
        // Another device would have to be waited for.
        if (cells.device().is_cpu() && cells.item<double>() == 0)
            return;
        const auto squares = fresco::ordered_sum(difference * difference * weight);
        const auto squares_count = cells * static_cast<double>(difference.size(0));
        sum = sum.defined() ? sum + squares : squares;
        count = count.defined() ? count + squares_count : squares_count;
    }
    torch::Tensor mean() const { return sum.defined() ? sum / count.clamp_min(1) : torch::Tensor(); }
};

}  // namespace

Cells low_pass(const torch::Tensor& picture, const torch::Tensor& mask, int size)
{
    const auto height = picture.size(1) / size;
    const auto width = picture.size(2) / size;
    if (height == 0 || width == 0)
        return {picture.new_zeros({picture.size(0), height, width}), picture.new_zeros({height, width})};
    const auto weight = mask.to(picture.scalar_type()).unsqueeze(0);
    const auto share = averaged(weight, size);
    const auto valid = (share >= 0.5).to(picture.scalar_type());
    const auto values = averaged(picture * weight, size) * valid / share.clamp_min(0.5);
    return {values, valid.squeeze(0)};
}

torch::Tensor luminance(const torch::Tensor& rgb)
{
    return (rgb[0] * 0.2126 + rgb[1] * 0.7152 + rgb[2] * 0.0722).unsqueeze(0);
}

torch::Tensor value_difference(const Cells& a, const Cells& b)
{
    Squares squares;
    squares.add(a.values - b.values, a.valid * b.valid);
    return squares.mean();
}

torch::Tensor step_difference(const Cells& a, const Cells& b)
{
    const auto difference = a.values - b.values;
    const auto valid = a.valid * b.valid;
    Squares squares;
    for (const int dimension : {0, 1})
    {
        const auto last = valid.size(dimension) - 1;
        if (last < 1)
            continue;
        squares.add(difference.narrow(dimension + 1, 1, last) - difference.narrow(dimension + 1, 0, last),
                    valid.narrow(dimension, 1, last) * valid.narrow(dimension, 0, last));
    }
    return squares.mean();
}

}  // namespace content_gradients
