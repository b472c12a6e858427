#include "robust_distance.h"

#include <fresco/parallel.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <array>
#include <cmath>
#include <vector>

namespace patch_match
{
namespace
{

constexpr double floor_of_root = 1e-4;
constexpr std::size_t rows_at_once = 8;  // Of patches.

struct Problem
{
    PatchGrid grid;
    torch::Tensor nearest;
    torch::Tensor style;
    double scale;
    double exponent;
    std::int64_t taking_part;
    int threads;
};

/// Neighboring rows of patches, and what they give.
template <class T>
struct Band
{
    std::int64_t first_row = 0;  ///< Of the picture.
    std::int64_t rows = 0;
    double value = 0;
    std::vector<T> gradient;  ///< 3 x rows x W
};

/// The value and its derivative, of the rows of patches from `begin` to `end`.
template <class T>
Band<T> accumulate(const Problem& problem, const T* picture, std::int64_t begin, std::int64_t end)
{
    const auto& grid = problem.grid;
    const auto plane = grid.width * grid.height;
    Band<T> band;
    band.first_row = grid.y(begin * grid.columns());
    band.rows = grid.y((end - 1) * grid.columns()) + patch_size - band.first_row;
    const auto band_plane = band.rows * grid.width;
    band.gradient.resize(static_cast<std::size_t>(3 * band_plane));
    const double share = 1 / static_cast<double>(problem.taking_part);
    const double power = problem.exponent / 2;
    double value = 0;
    std::array<T, patch_values> difference;
    for (std::int64_t i = begin * grid.columns(); i < end * grid.columns(); ++i)
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
        T* gradient = band.gradient.data() + corner - band.first_row * grid.width;
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                for (std::int64_t column = 0; column < patch_size; ++column, ++k)
                    gradient[c * band_plane + row * grid.width + column] += factor * difference[k];
    }
    band.value = value * share;
    return band;
}

/// The value; writes its derivative (3 x H x W). Bands do not depend on the number of threads and are added in order.
template <class T>
double summed(const Problem& problem, const T* picture, T* gradient)
{
    const auto& grid = problem.grid;
    const auto rows = static_cast<std::size_t>(grid.rows());
    std::vector<Band<T>> bands((rows + rows_at_once - 1) / rows_at_once);
    fresco::parallel_for(rows, rows_at_once, problem.threads,
                         [&](std::size_t begin, std::size_t end)
                         {
                             bands[begin / rows_at_once] =
                                 accumulate(problem, picture, static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end));
                         });
    double value = 0;
    for (const Band<T>& band : bands)
    {
        value += band.value;
        const auto count = band.rows * grid.width;
        for (std::int64_t c = 0; c < 3; ++c)
        {
            T* out = gradient + (c * grid.height + band.first_row) * grid.width;
            const T* from = band.gradient.data() + c * count;
            for (std::int64_t i = 0; i < count; ++i)
                out[i] += from[i];
        }
    }
    return value;
}

struct RobustDistance : torch::autograd::Function<RobustDistance>
{
    static torch::Tensor forward(torch::autograd::AutogradContext* context, const torch::Tensor& input, const Problem& problem)
    {
        const auto picture = input.contiguous();
        auto gradient = at::zeros_like(picture);
        const double value = picture.scalar_type() == at::kDouble
                                 ? summed(problem, picture.data_ptr<double>(), gradient.data_ptr<double>())
                                 : summed(problem, picture.data_ptr<float>(), gradient.data_ptr<float>());
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
                              const torch::Tensor& style, double scale, double exponent, int threads)
{
    std::int64_t taking_part = 0;
    for (std::int64_t i = 0; i < nearest.numel(); ++i)
        taking_part += nearest.data_ptr<int>()[i] >= 0 ? 1 : 0;
    if (taking_part == 0)
        return {};
    return RobustDistance::apply(picture, Problem{grid, nearest, style, scale, exponent, taking_part, threads});
}

}  // namespace patch_match
