#include "samples.h"

#include <fresco/random.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

namespace nnfm
{
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
