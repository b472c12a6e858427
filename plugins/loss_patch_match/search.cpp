#include "search.h"

#include <fresco/matrix_multiply.h>
#include <fresco/parallel.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <limits>
#include <mutex>
#include <vector>

namespace patch_match
{
namespace
{

// 128 x 4 096 products are 2 MiB: they are read again while they are still in the cache.
constexpr std::int64_t rows_at_once = 128;
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
        style_ = input.style.contiguous();
        for (const float length : square_lengths(style_))
            style_offset_.push_back(static_cast<float>(1 + weight_) * length);
    }

    std::int64_t queries() const { return queries_.size(0); }
    std::size_t style_count() const { return style_offset_.size(); }

    /// Calls use(piece, i, first_j, distances, count) for every query and block of style patches, `piece` being what begin() gave
    /// for the queries that one thread takes at once, and end(piece) after these; distances may be a hair below 0.
    template <class Begin, class Use, class End>
    void each(const fresco::Progress& progress, const Begin& begin_piece, const Use& use, const End& end_piece) const
    {
        fresco::parallel_for(static_cast<std::size_t>(queries()), rows_at_once, progress.threads(),
                             [&](std::size_t begin, std::size_t end)
                             {
                                 auto piece = begin_piece();
                                 const auto width = static_cast<std::size_t>(style_.size(1));
                                 const auto row_stride = static_cast<std::ptrdiff_t>(width);
                                 std::vector<float> products((end - begin) * columns_at_once);
                                 for (std::int64_t first = 0; first < style_.size(0); first += columns_at_once)
                                 {
                                     progress.check_canceled();
                                     const auto count = std::min(columns_at_once, style_.size(0) - first);
                                     fresco::multiply_matrices(
                                         {queries_.data_ptr<float>() + begin * width, end - begin, width, row_stride, 1},
                                         {style_.data_ptr<float>() + static_cast<std::size_t>(first) * width, width,
                                          static_cast<std::size_t>(count), 1, row_stride},
                                         products.data(), 1);
                                     const float* style = style_offset_.data() + first;
                                     for (std::size_t i = begin; i < end; ++i)
                                     {
                                         float* row = &products[(i - begin) * static_cast<std::size_t>(count)];
                                         const float own = offset_[i];
                                         for (std::int64_t j = 0; j < count; ++j)
                                             row[j] += own + style[j];
                                         use(piece, i, first, row, count);
                                     }
                                 }
                                 end_piece(piece);
                             });
    }

  private:
    torch::Tensor queries_;
    double weight_;
    std::vector<float> offset_;
    std::vector<float> style_offset_;
    torch::Tensor style_;
};

}  // namespace

torch::Tensor nearest_patches(const SearchInput& input, const fresco::Progress& progress)
{
    const at::NoGradGuard no_gradient;
    const Distances distances(input);
    std::vector<float> divisor(distances.style_count(), std::numeric_limits<float>::max());
    const auto lower = [](float* best, const float* row, std::size_t count)
    {
        for (std::size_t j = 0; j < count; ++j)
            best[j] = row[j] < best[j] ? row[j] : best[j];
    };
    std::mutex mutex;
    distances.each(
        progress, [&] { return std::vector<float>(divisor.size(), std::numeric_limits<float>::max()); },
        [&](std::vector<float>& least, std::size_t, std::int64_t first, const float* row, std::int64_t count)
        { lower(least.data() + first, row, static_cast<std::size_t>(count)); },
        [&](const std::vector<float>& least)
        {
            const std::lock_guard lock(mutex);
            lower(divisor.data(), least.data(), divisor.size());
        });
    for (float& value : divisor)
        value = 1 / (static_cast<float>(input.tolerance) + std::max(value, 0.0F));

    auto nearest = at::zeros({distances.queries()}, at::kInt);
    std::vector<float> smallest(static_cast<std::size_t>(distances.queries()), std::numeric_limits<float>::max());
    struct Nothing
    {
    };
    distances.each(
        progress, [] { return Nothing{}; },
        [&](Nothing, std::size_t i, std::int64_t first, float* row, std::int64_t count)
        {
            const float* factor = divisor.data() + first;
            for (std::int64_t j = 0; j < count; ++j)
                row[j] *= factor[j];
            float low = row[0];
            for (std::int64_t j = 1; j < count; ++j)
                low = row[j] < low ? row[j] : low;
            if (low >= smallest[i])
                return;
            smallest[i] = low;
            nearest.data_ptr<int>()[i] = static_cast<int>(first + (std::find(row, row + count, low) - row));
        },
        [](Nothing) {});
    return nearest;
}

}  // namespace patch_match
