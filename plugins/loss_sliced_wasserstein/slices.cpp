#include "slices.h"

#include <fresco/parallel.h>
#include <fresco/radix_sort.h>
#include <fresco/random.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Dispatch.h>
#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace sliced
{
namespace
{

constexpr std::size_t rows_per_piece = 4;

/// Positions of the `count` values of a row in ascending order. Values that differ by less than float32 resolves may be swapped.
template <class T>
std::vector<std::uint64_t> ranked(const T* row, std::int64_t count)
{
    std::vector<std::uint64_t> entries(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < entries.size(); ++i)
        entries[i] = static_cast<std::uint64_t>(fresco::ordered_key(static_cast<float>(row[i]))) << 32U | i;
    fresco::sort_by_upper_half(entries, std::numeric_limits<std::uint32_t>::max());
    for (auto& entry : entries)
        entry &= 0xffffffffU;
    return entries;
}

/// A row of M ascending values as `count` values.
template <class T>
T stretched(const T* sorted, std::int64_t size, std::int64_t rank, std::int64_t count)
{
    const double place =
        std::clamp((static_cast<double>(rank) + 0.5) * static_cast<double>(size) / static_cast<double>(count) - 0.5, 0.0,
                   static_cast<double>(size - 1));
    const auto below = static_cast<std::int64_t>(place);
    const auto share = static_cast<T>(place - static_cast<double>(below));
    return share > 0 ? sorted[below] * (1 - share) + sorted[below + 1] * share : sorted[below];
}

/// Calls work(row) for every row, on several threads.
template <class Work>
void each_row(std::int64_t rows, const Work& work)
{
    fresco::parallel_for(static_cast<std::size_t>(rows), rows_per_piece, at::get_num_threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (std::size_t row = begin; row < end; ++row)
                                 work(static_cast<std::int64_t>(row));
                         });
}

/// Places between sorted entries, as tensors: the way for devices other than the CPU.
torch::Tensor stretched_rows(const torch::Tensor& sorted, std::int64_t count)
{
    const auto size = sorted.size(1);
    const auto place = ((at::arange(count, sorted.options().dtype(at::kDouble)) + 0.5) *
                            (static_cast<double>(size) / static_cast<double>(count)) -
                        0.5)
                           .clamp(0, static_cast<double>(size - 1));
    const auto below = place.to(at::kLong);
    const auto share = (place - below).to(sorted.scalar_type());
    return sorted.index_select(1, below) * (1 - share) + sorted.index_select(1, (below + 1).clamp_max(size - 1)) * share;
}

}  // namespace

torch::Tensor random_directions(std::int64_t count, std::int64_t dimensions, std::uint64_t seed,
                                const torch::TensorOptions& options)
{
    fresco::Random random(seed);
    auto directions = at::empty({count, dimensions}, at::kDouble);
    double* row = directions.data_ptr<double>();
    for (std::int64_t k = 0; k < count; ++k, row += dimensions)
    {
        double squares = 0;
        while (squares < 1e-12)
        {
            squares = 0;
            for (std::int64_t c = 0; c < dimensions; ++c)
            {
                row[c] = random.normal();
                squares += row[c] * row[c];
            }
        }
        for (std::int64_t c = 0; c < dimensions; ++c)
            row[c] /= std::sqrt(squares);
    }
    return fresco::sent_to(directions.to(options.device(at::kCPU)), options.device());
}

torch::Tensor sorted_rows(const torch::Tensor& values)
{
    if (!values.device().is_cpu())
        return std::get<0>(values.sort(1));
    const auto source = values.contiguous();
    auto result = at::empty_like(source);
    const auto count = source.size(1);
    AT_DISPATCH_FLOATING_TYPES(source.scalar_type(), "sorted_rows",
                               [&]
                               {
                                   each_row(source.size(0),
                                            [&](std::int64_t row)
                                            {
                                                const scalar_t* in = source.data_ptr<scalar_t>() + row * count;
                                                scalar_t* out = result.data_ptr<scalar_t>() + row * count;
                                                for (const auto position : ranked(in, count))
                                                    *out++ = in[position];
                                            });
                               });
    return result;
}

torch::Tensor of_same_rank(const torch::Tensor& values, const torch::Tensor& sorted)
{
    const at::NoGradGuard no_gradient;
    const auto count = values.size(1);
    const auto size = sorted.size(1);
    if (!values.device().is_cpu())
        return at::empty_like(values).scatter(1, values.argsort(std::int64_t{1}, false), stretched_rows(sorted, count));
    const auto source = values.contiguous();
    const auto target = sorted.contiguous();
    auto result = at::empty_like(source);
    AT_DISPATCH_FLOATING_TYPES(source.scalar_type(), "of_same_rank",
                               [&]
                               {
                                   each_row(source.size(0),
                                            [&](std::int64_t row)
                                            {
                                                scalar_t* out = result.data_ptr<scalar_t>() + row * count;
                                                const scalar_t* style = target.data_ptr<scalar_t>() + row * size;
                                                std::int64_t rank = 0;
                                                for (const auto position :
                                                     ranked(source.data_ptr<scalar_t>() + row * count, count))
                                                    out[position] = stretched(style, size, rank++, count);
                                            });
                               });
    return result;
}

torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& target, const torch::Tensor& directions)
{
    const auto projected = fresco::matrix_product(directions, features);
    const auto style = sorted_rows(fresco::matrix_product(directions, target));
    const auto difference = projected - of_same_rank(projected.detach(), style);
    return fresco::ordered_mean(difference * difference);
}

}  // namespace sliced
