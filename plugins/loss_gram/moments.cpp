#include "moments.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>

namespace gram
{
namespace
{

struct MomentsFunction : torch::autograd::Function<MomentsFunction>
{
    static torch::autograd::variable_list forward(torch::autograd::AutogradContext* context, const torch::Tensor& features)
    {
        context->save_for_backward({features});
        const auto count = static_cast<double>(features.size(1));
        return {fresco::ordered_mean(features, 1), fresco::matrix_product(features, features.t()).div_(count)};
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto features = context->get_saved_variables()[0];
        const auto count = static_cast<double>(features.size(1));
        torch::Tensor result;
        if (gradients[1].defined())
        {
            // Symmetric, so that the product can keep the order of the features in memory.
            const auto factor = (gradients[1] + gradients[1].t()).div_(count);
            result = features.is_contiguous() ? fresco::matrix_product(factor, features)
                                              : fresco::matrix_product(features.t(), factor).t();
        }
        else
            result = at::zeros_like(features);
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
