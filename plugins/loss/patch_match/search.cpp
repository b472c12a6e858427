#include "search.h"

#include <fresco/math.h>
#include <fresco/parallel.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <cmath>
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
        fresco::parallel_for(static_cast<std::size_t>(queries()), rows_at_once, progress,
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
            // NaN is below nothing: style patch 0 stays, so that the loss becomes NaN.
            if (!(low < smallest[i]))
                return;
            smallest[i] = low;
            nearest.data_ptr<int>()[i] = static_cast<int>(first + (std::find(row, row + count, low) - row));
        },
        [](Nothing) {});
    return nearest;
}

namespace
{

constexpr double floor_of_root = 1e-4;
constexpr std::size_t patch_rows_at_once = 8;  // Rows of patches.

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
struct Band
{
    std::int64_t first_row = 0;  ///< First row of the picture.
    std::int64_t rows = 0;
    double value = 0;
    std::vector<float> gradient;  ///< 3 x rows x W
};

/// The value and its derivative, of the rows of patches from `begin` to `end`.
Band accumulate(const Problem& problem, const float* picture, std::int64_t begin, std::int64_t end)
{
    const auto& grid = problem.grid;
    const auto plane = grid.width * grid.height;
    Band band;
    band.first_row = grid.y(begin * grid.columns());
    band.rows = grid.y((end - 1) * grid.columns()) + patch_size - band.first_row;
    const auto band_plane = band.rows * grid.width;
    band.gradient.resize(static_cast<std::size_t>(3 * band_plane));
    const double share = 1 / static_cast<double>(problem.taking_part);
    const double power = problem.exponent / 2;
    double value = 0;
    std::array<float, patch_values> difference;
    for (std::int64_t i = begin * grid.columns(); i < end * grid.columns(); ++i)
    {
        const auto match = problem.nearest.data_ptr<int>()[i];
        if (match < 0)
            continue;
        const float* style = problem.style.data_ptr<float>() + static_cast<std::int64_t>(match) * patch_values;
        const auto corner = grid.y(i) * grid.width + grid.x(i);
        std::array<float, patch_size> squares{};
        std::size_t k = 0;
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                for (std::int64_t column = 0; column < patch_size; ++column, ++k)
                {
                    const float d = picture[c * plane + corner + row * grid.width + column] - style[k];
                    difference[k] = d;
                    squares[static_cast<std::size_t>(column)] += d * d;
                }
        double sum = 0;
        for (const float square : squares)
            sum += static_cast<double>(square);
        const double base = sum / problem.scale + floor_of_root;
        const double term = std::pow(base, power);
        value += term;
        const auto factor = static_cast<float>(share * 2 * power * term / (base * problem.scale));
        k = 0;
        float* gradient = band.gradient.data() + corner - band.first_row * grid.width;
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                for (std::int64_t column = 0; column < patch_size; ++column, ++k)
                    gradient[c * band_plane + row * grid.width + column] += factor * difference[k];
    }
    band.value = value * share;
    return band;
}

/// The value; writes its derivative (3 x H x W). Bands do not depend on the number of threads and are added in order.
double summed(const Problem& problem, const float* picture, float* gradient)
{
    const auto& grid = problem.grid;
    const auto rows = static_cast<std::size_t>(grid.rows());
    std::vector<Band> bands((rows + patch_rows_at_once - 1) / patch_rows_at_once);
    fresco::parallel_for(rows, patch_rows_at_once, problem.threads,
                         [&](std::size_t begin, std::size_t end)
                         {
                             bands[begin / patch_rows_at_once] =
                                 accumulate(problem, picture, static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end));
                         });
    double value = 0;
    for (const Band& band : bands)
    {
        value += band.value;
        const auto count = band.rows * grid.width;
        for (std::int64_t c = 0; c < 3; ++c)
        {
            float* out = gradient + (c * grid.height + band.first_row) * grid.width;
            const float* from = band.gradient.data() + c * count;
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
        const double value = summed(problem, picture.data_ptr<float>(), gradient.data_ptr<float>());
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
