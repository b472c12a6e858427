#include "nearest.h"

#include <fresco/parallel.h>
#include <fresco/random.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Dispatch.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace nnfm
{
namespace
{

// 512 x 4 096 products are 8 MiB.
constexpr std::int64_t queries_at_once = 512;
constexpr std::int64_t style_at_once = 4096;
constexpr std::size_t rows_per_piece = 64;
constexpr double shortest = 1e-12;

/// The largest cosine of each query so far, and where it was found.
template <class T>
struct Best
{
    std::vector<T> cosine;
    std::vector<std::int64_t> index;

    explicit Best(std::int64_t queries)
        : cosine(static_cast<std::size_t>(queries), std::numeric_limits<T>::lowest()), index(static_cast<std::size_t>(queries), 0)
    {
    }

    /// Products (n x count) of queries from `first_query` on with style rows from `first_style` on.
    void take(const torch::Tensor& products, std::int64_t first_query, std::int64_t first_style)
    {
        const auto count = products.size(1);
        const T* values = products.data_ptr<T>();
        fresco::parallel_for(static_cast<std::size_t>(products.size(0)), rows_per_piece, at::get_num_threads(),
                             [&](std::size_t begin, std::size_t end)
                             {
                                 for (std::size_t i = begin; i < end; ++i)
                                 {
                                     const T* row = values + static_cast<std::int64_t>(i) * count;
                                     T high = row[0];
                                     for (std::int64_t j = 1; j < count; ++j)
                                         high = row[j] > high ? row[j] : high;
                                     const auto query = static_cast<std::size_t>(first_query) + i;
                                     if (!(high > cosine[query]))
                                         continue;
                                     cosine[query] = high;
                                     index[query] = first_style + (std::find(row, row + count, high) - row);
                                 }
                             });
    }
};

template <class T>
torch::Tensor search(const torch::Tensor& queries, const std::vector<torch::Tensor>& style_blocks)
{
    Best<T> best(queries.size(0));
    for (std::int64_t begin = 0; begin < queries.size(0); begin += queries_at_once)
    {
        const auto rows = queries.narrow(0, begin, std::min(queries_at_once, queries.size(0) - begin));
        std::int64_t first = 0;
        for (const auto& block : style_blocks)
        {
            best.take(fresco::matrix_product(rows, block).contiguous(), begin, first);
            first += block.size(1);
        }
    }
    auto result = at::empty({queries.size(0)}, at::kLong);
    std::copy(best.index.begin(), best.index.end(), result.data_ptr<std::int64_t>());
    return result;
}

/// For devices other than the CPU.
torch::Tensor search_elsewhere(const torch::Tensor& queries, const torch::Tensor& style)
{
    std::vector<torch::Tensor> found;
    const auto columns = style.t();
    // The memory of a block, 64 MiB, whatever M is.
    const auto rows = std::max<std::int64_t>(1, (std::int64_t{1} << 24) / style.size(0));
    for (std::int64_t begin = 0; begin < queries.size(0); begin += rows)
        found.push_back(queries.narrow(0, begin, std::min(rows, queries.size(0) - begin)).mm(columns).argmax(1));
    return at::cat(found);
}

}  // namespace

torch::Tensor unit_rows(const torch::Tensor& rows)
{
    return rows / fresco::ordered_sum(rows * rows, 1).sqrt().clamp_min(shortest).unsqueeze(1);
}

torch::Tensor most_similar(const torch::Tensor& queries, const torch::Tensor& style)
{
    const at::NoGradGuard no_gradient;
    if (!queries.device().is_cpu())
        return search_elsewhere(queries, style);
    std::vector<torch::Tensor> blocks;
    for (std::int64_t begin = 0; begin < style.size(0); begin += style_at_once)
        blocks.push_back(style.narrow(0, begin, std::min(style_at_once, style.size(0) - begin)).t().contiguous());
    torch::Tensor result;
    AT_DISPATCH_FLOATING_TYPES(queries.scalar_type(), "most_similar",
                               [&] { result = search<scalar_t>(queries.contiguous(), blocks); });
    return result;
}

torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& style)
{
    const auto rows = features.t().contiguous();
    const auto matches = style.index_select(0, most_similar(unit_rows(rows.detach()), style));
    // A tiny number under the root: the derivative of a length is not finite at zero.
    const auto lengths = (fresco::ordered_sum(rows * rows, 1) + shortest * shortest).sqrt();
    return 1 - fresco::ordered_mean(fresco::ordered_sum(rows * matches, 1) / lengths);
}

namespace
{

/// Its own derivative: torch adds up the gradient of index_select column by column, these columns are unique.
struct Columns : torch::autograd::Function<Columns>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& values, const at::Tensor& columns)
    {
        context->save_for_backward({columns});
        context->saved_data["count"] = values.size(1);
        return values.index_select(1, columns);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto columns = context->get_saved_variables()[0];
        const auto zeros = at::zeros({gradients[0].size(0), context->saved_data["count"].toInt()}, gradients[0].options());
        return {zeros.index_copy(1, columns, gradients[0]), at::Tensor()};
    }
};

}  // namespace

torch::Tensor sampled_columns(const torch::Tensor& features, std::int64_t most, std::uint64_t seed)
{
    const auto count = features.size(1);
    if (count <= most)
        return features;
    fresco::Random random(seed);
    auto columns = at::empty({most}, at::kLong);
    for (std::int64_t i = 0; i < most; ++i)
    {
        const auto begin = i * count / most;
        columns.data_ptr<std::int64_t>()[i] = begin + random.below((i + 1) * count / most - begin);
    }
    return Columns::apply(features, fresco::sent_to(columns, features.device()));
}

}  // namespace nnfm
