#include "spherical_k_means.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace dictionary
{
namespace
{

/// Scales rows to length 1; rows shorter than any rounding error become the first axis.
void normalise_rows(torch::Tensor& rows)
{
    const auto width = rows.size(1);
    for (std::int64_t i = 0; i < rows.size(0); ++i)
    {
        float* row = rows.data_ptr<float>() + i * width;
        double sum = 0;
        for (std::int64_t j = 0; j < width; ++j)
            sum += static_cast<double>(row[j]) * static_cast<double>(row[j]);
        const double norm = std::sqrt(sum);
        if (norm < 1e-12)
        {
            std::fill(row, row + width, 0.0F);
            row[0] = 1;
            continue;
        }
        for (std::int64_t j = 0; j < width; ++j)
            row[j] = static_cast<float>(static_cast<double>(row[j]) / norm);
    }
}

/// The first `count` of a seeded shuffle of [0, total), begun again where count > total.
std::vector<std::int64_t> draw(std::int64_t total, std::int64_t count, fresco::Random& random)
{
    std::vector<std::int64_t> order(static_cast<std::size_t>(total));
    std::iota(order.begin(), order.end(), std::int64_t{0});
    const auto shuffled = std::min(total, count);
    for (std::int64_t i = 0; i < shuffled; ++i)
        std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(i + random.below(total - i))]);
    std::vector<std::int64_t> drawn;
    for (std::int64_t i = 0; i < count; ++i)
        drawn.push_back(order[static_cast<std::size_t>(i % total)]);
    return drawn;
}

struct Assignment
{
    std::vector<std::int64_t> centre;
    std::vector<float> fit;
};

/// `fits`: N x K.
Assignment best_centres(const torch::Tensor& fits)
{
    const auto count = fits.size(0);
    const auto centres = fits.size(1);
    Assignment result{std::vector<std::int64_t>(static_cast<std::size_t>(count)),
                      std::vector<float>(static_cast<std::size_t>(count))};
    for (std::int64_t i = 0; i < count; ++i)
    {
        const float* row = fits.data_ptr<float>() + i * centres;
        const auto best = std::max_element(row, row + centres);
        result.centre[static_cast<std::size_t>(i)] = best - row;
        result.fit[static_cast<std::size_t>(i)] = *best;
    }
    return result;
}

void fill_empty(torch::Tensor& sums, const torch::Tensor& samples, const std::vector<std::int64_t>& sizes,
                std::vector<float>& fit)
{
    const auto width = sums.size(1);
    for (std::int64_t k = 0; k < sums.size(0); ++k)
    {
        if (sizes[static_cast<std::size_t>(k)] > 0)
            continue;
        const auto worst = std::min_element(fit.begin(), fit.end()) - fit.begin();
        fit[static_cast<std::size_t>(worst)] = 2;  // no dot product of unit vectors reaches this: not taken twice
        std::copy_n(samples.data_ptr<float>() + worst * width, width, sums.data_ptr<float>() + k * width);
    }
}

}  // namespace

torch::Tensor spherical_k_means(const torch::Tensor& samples, int centres, int iterations, fresco::Random& random,
                                fresco::Progress& progress)
{
    auto unit = samples.clone(at::MemoryFormat::Contiguous);
    normalise_rows(unit);
    const auto width = unit.size(1);
    auto result = at::empty({centres, width}, at::kFloat);
    const auto first = draw(unit.size(0), centres, random);
    for (std::int64_t k = 0; k < centres; ++k)
        std::copy_n(unit.data_ptr<float>() + first[static_cast<std::size_t>(k)] * width, width,
                    result.data_ptr<float>() + k * width);

    for (int round = 0; round < iterations; ++round)
    {
        progress.check_cancelled();
        auto assignment = best_centres(fresco::matrix_product(unit, result.t().contiguous()).contiguous());
        result = at::zeros({centres, width}, at::kFloat);
        std::vector<std::int64_t> sizes(static_cast<std::size_t>(centres), 0);
        for (std::int64_t i = 0; i < unit.size(0); ++i)
        {
            const auto k = assignment.centre[static_cast<std::size_t>(i)];
            ++sizes[static_cast<std::size_t>(k)];
            float* sum = result.data_ptr<float>() + k * width;
            const float* sample = unit.data_ptr<float>() + i * width;
            for (std::int64_t j = 0; j < width; ++j)
                sum[j] += sample[j];
        }
        fill_empty(result, unit, sizes, assignment.fit);
        normalise_rows(result);
    }
    return result;
}

}  // namespace dictionary
