#include "search.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace patch_match
{
namespace
{

// 256 x 4 096 products are 4 MiB: they are read again while they are still in the cache.
constexpr std::int64_t rows_at_once = 256;
constexpr std::int64_t columns_at_once = 4096;

std::vector<float> square_lengths(const torch::Tensor& rows)
{
    std::vector<float> result;
    const auto width = rows.size(1);
    for (std::int64_t i = 0; i < rows.size(0); ++i)
    {
        const float* row = rows.data_ptr<float>() + i * width;
        double sum = 0;
        for (std::int64_t k = 0; k < width; ++k)
            sum += static_cast<double>(row[k]) * static_cast<double>(row[k]);
        result.push_back(static_cast<float>(sum));
    }
    return result;
}

/// Distances of blocks of queries to blocks of style patches.
class Distances
{
  public:
    explicit Distances(const SearchInput& input)
        : queries_(((input.patches + input.guide * input.guide_weight) * -2.0).contiguous()), weight_(input.guide_weight)
    {
        const auto own = square_lengths(input.patches.contiguous());
        const auto guide = square_lengths(input.guide.contiguous());
        for (std::size_t i = 0; i < own.size(); ++i)
            offset_.push_back(own[i] + static_cast<float>(weight_) * guide[i]);
        const auto style = input.style.contiguous();
        for (const float length : square_lengths(style))
            style_offset_.push_back(static_cast<float>(1 + weight_) * length);
        for (std::int64_t begin = 0; begin < style.size(0); begin += columns_at_once)
            style_blocks_.push_back(style.narrow(0, begin, std::min(columns_at_once, style.size(0) - begin)).t().contiguous());
    }

    std::int64_t queries() const { return queries_.size(0); }
    std::size_t style_count() const { return style_offset_.size(); }

    /// Calls use(i, first_j, distances, count) for every query and block of style patches; distances may be a hair below 0.
    template <class Use>
    void each(const fresco::Progress& progress, const Use& use)
    {
        for (std::int64_t begin = 0; begin < queries(); begin += rows_at_once)
        {
            progress.check_cancelled();
            const auto rows = queries_.narrow(0, begin, std::min(rows_at_once, queries() - begin));
            std::int64_t first = 0;
            for (const auto& block : style_blocks_)
            {
                const auto products = fresco::matrix_product(rows, block).contiguous();
                const auto count = block.size(1);
                for (std::int64_t i = 0; i < rows.size(0); ++i)
                {
                    float* row = products.data_ptr<float>() + i * count;
                    const float own = offset_[static_cast<std::size_t>(begin + i)];
                    const float* style = style_offset_.data() + first;
                    for (std::int64_t j = 0; j < count; ++j)
                        row[j] += own + style[j];
                    use(begin + i, first, row, count);
                }
                first += count;
            }
        }
    }

  private:
    torch::Tensor queries_;
    double weight_;
    std::vector<float> offset_;
    std::vector<float> style_offset_;
    std::vector<torch::Tensor> style_blocks_;
};

}  // namespace

torch::Tensor nearest_patches(const SearchInput& input, const fresco::Progress& progress)
{
    const at::NoGradGuard no_gradient;
    Distances distances(input);
    std::vector<float> divisor(distances.style_count(), std::numeric_limits<float>::max());
    distances.each(progress,
                   [&](std::int64_t, std::int64_t first, const float* row, std::int64_t count)
                   {
                       float* best = divisor.data() + first;
                       for (std::int64_t j = 0; j < count; ++j)
                           best[j] = row[j] < best[j] ? row[j] : best[j];
                   });
    for (float& value : divisor)
        value = 1 / (static_cast<float>(input.tolerance) + std::max(value, 0.0F));

    auto nearest = at::zeros({distances.queries()}, at::kInt);
    std::vector<float> smallest(static_cast<std::size_t>(distances.queries()), std::numeric_limits<float>::max());
    distances.each(progress,
                   [&](std::int64_t i, std::int64_t first, float* row, std::int64_t count)
                   {
                       const float* factor = divisor.data() + first;
                       for (std::int64_t j = 0; j < count; ++j)
                           row[j] *= factor[j];
                       float low = row[0];
                       for (std::int64_t j = 1; j < count; ++j)
                           low = row[j] < low ? row[j] : low;
                       if (low >= smallest[static_cast<std::size_t>(i)])
                           return;
                       smallest[static_cast<std::size_t>(i)] = low;
                       nearest.data_ptr<int>()[i] = static_cast<int>(first + (std::find(row, row + count, low) - row));
                   });
    return nearest;
}

}  // namespace patch_match
