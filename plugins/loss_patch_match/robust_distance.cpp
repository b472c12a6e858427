#include "robust_distance.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <array>
#include <cmath>

namespace patch_match
{
namespace
{

constexpr double floor_of_root = 1e-4;

struct Problem
{
    PatchGrid grid;
    torch::Tensor nearest;
    torch::Tensor style;
    double scale;
    double exponent;
    std::int64_t taking_part;
};

/// The value; adds its derivative to `gradient` (3 x H x W).
template <class T>
double accumulate(const Problem& problem, const T* picture, T* gradient)
{
    const auto& grid = problem.grid;
    const auto plane = grid.width * grid.height;
    const double share = 1 / static_cast<double>(problem.taking_part);
    const double power = problem.exponent / 2;
    double value = 0;
    std::array<T, patch_values> difference;
    for (std::int64_t i = 0; i < grid.count(); ++i)
    {
        const auto match = problem.nearest.data_ptr<int>()[i];
        if (match < 0)
            continue;
        const float* style = problem.style.data_ptr<float>() + static_cast<std::int64_t>(match) * patch_values;
        const auto corner = grid.y(i) * grid.width + grid.x(i);
        std::array<T, patch_size> squares{};
        std::size_t k = 0;
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                for (std::int64_t column = 0; column < patch_size; ++column, ++k)
                {
                    const T d = picture[c * plane + corner + row * grid.width + column] - static_cast<T>(style[k]);
                    difference[k] = d;
                    squares[static_cast<std::size_t>(column)] += d * d;
                }
        double sum = 0;
        for (const T square : squares)
            sum += static_cast<double>(square);
        const double base = sum / problem.scale + floor_of_root;
        const double term = std::pow(base, power);
        value += term;
        const auto factor = static_cast<T>(share * 2 * power * term / (base * problem.scale));
        k = 0;
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                for (std::int64_t column = 0; column < patch_size; ++column, ++k)
                    gradient[c * plane + corner + row * grid.width + column] += factor * difference[k];
    }
    return value * share;
}

struct RobustDistance : torch::autograd::Function<RobustDistance>
{
    static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input, const Problem& problem)
    {
        const auto picture = input.contiguous();
        auto gradient = at::zeros_like(picture);
        const double value = picture.scalar_type() == at::kDouble
                                 ? accumulate(problem, picture.data_ptr<double>(), gradient.data_ptr<double>())
                                 : accumulate(problem, picture.data_ptr<float>(), gradient.data_ptr<float>());
        context->save_for_backward({gradient});
        return at::full({}, value, picture.options());
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        return {context->get_saved_variables()[0] * gradients[0], torch::Tensor()};
    }
};

}  // namespace

torch::Tensor robust_distance(const torch::Tensor& picture, const PatchGrid& grid, const torch::Tensor& nearest,
                              const torch::Tensor& style, double scale, double exponent)
{
    std::int64_t taking_part = 0;
    for (std::int64_t i = 0; i < nearest.numel(); ++i)
        taking_part += nearest.data_ptr<int>()[i] >= 0 ? 1 : 0;
    if (taking_part == 0)
        return {};
    return RobustDistance::apply(picture, Problem{grid, nearest, style, scale, exponent, taking_part});
}

}  // namespace patch_match
