#include "moments.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>

namespace gram
{
namespace
{

// A block of 64 channels stays in the second-level cache, and 8 192 float32 terms are few enough to lose no digit that matters.
constexpr std::int64_t block = 8192;

torch::Tensor second_moment(const torch::Tensor& features)
{
    const auto channels = features.size(0);
    const auto count = features.size(1);
    auto sum = at::zeros({channels, channels}, features.options());
    for (std::int64_t begin = 0; begin < count; begin += block)
    {
        const auto part = features.narrow(1, begin, std::min(block, count - begin)).contiguous();
        sum.add_(fresco::matrix_product(part, part.t().contiguous()));
    }
    return sum.div_(static_cast<double>(count));
}

struct MomentsFunction : torch::autograd::Function<MomentsFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& input)
    {
        const auto features = input.contiguous();
        context->save_for_backward({features});
        return {fresco::ordered_mean(features, 1), second_moment(features)};
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto features = context->get_saved_variables()[0];
        const auto count = static_cast<double>(features.size(1));
        auto result = at::zeros_like(features);
        if (gradients[1].defined())
            result = fresco::matrix_product((gradients[1] + gradients[1].t()).div_(count).contiguous(), features);
        if (gradients[0].defined())
            result = result + (gradients[0] / count).unsqueeze(1);
        return {result};
    }
};

torch::Tensor sum_of_squares(const torch::Tensor& x)
{
    return fresco::ordered_sum(x * x);
}

}  // namespace

Moments moments(const torch::Tensor& features)
{
    const auto values = MomentsFunction::apply(features);
    return {values[0], values[1]};
}

torch::Tensor covariance(const Moments& moments)
{
    return moments.second - moments.mean.unsqueeze(1) * moments.mean.unsqueeze(0);
}

torch::Tensor mean_square_difference(const torch::Tensor& a, const torch::Tensor& target)
{
    return sum_of_squares(a - target) / static_cast<double>(a.numel());
}

torch::Tensor relative_square_difference(const torch::Tensor& a, const torch::Tensor& target)
{
    const double scale = sum_of_squares(target).item<double>();
    return sum_of_squares(a - target) / (scale > 0 ? scale : 1.0);
}

}  // namespace gram
