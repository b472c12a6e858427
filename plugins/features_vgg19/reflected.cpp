#include "reflected.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

namespace vgg19
{
namespace
{

/// The row or column of the framed maps that each of the two outer ones is the picture of.
struct Sources
{
    std::int64_t first;
    std::int64_t last;
};

Sources sources(std::int64_t count)
{
    // A side of one pixel has nothing to reflect: that pixel goes on.
    return count > 1 ? Sources{2, count - 1} : Sources{1, 1};
}

struct Reflected : torch::autograd::Function<Reflected>
{
    static at::Tensor forward(torch::autograd::AutogradContext*, const at::Tensor& maps)
    {
        const auto height = maps.size(2);
        const auto width = maps.size(3);
        auto framed =
            at::empty({maps.size(0), maps.size(1), height + 2, width + 2}, maps.options(), at::MemoryFormat::ChannelsLast);
        framed.slice(2, 1, height + 1).slice(3, 1, width + 1).copy_(maps);
        for (const std::int64_t dimension : {2, 3})
        {
            const auto count = maps.size(dimension);
            const auto from = sources(count);
            framed.select(dimension, 0).copy_(framed.select(dimension, from.first));
            framed.select(dimension, count + 1).copy_(framed.select(dimension, from.last));
        }
        return framed;
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext*, torch::autograd::variable_list gradients)
    {
        auto framed = gradients[0].clone(at::MemoryFormat::ChannelsLast);
        const auto height = framed.size(2) - 2;
        const auto width = framed.size(3) - 2;
        for (const std::int64_t dimension : {3, 2})
        {
            const auto count = framed.size(dimension) - 2;
            const auto from = sources(count);
            framed.select(dimension, from.first).add_(framed.select(dimension, 0));
            framed.select(dimension, from.last).add_(framed.select(dimension, count + 1));
        }
        return {framed.slice(2, 1, height + 1).slice(3, 1, width + 1)};
    }
};

}  // namespace

torch::Tensor reflected(const torch::Tensor& maps)
{
    return Reflected::apply(maps);
}

}  // namespace vgg19
