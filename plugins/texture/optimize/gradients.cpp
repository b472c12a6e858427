#include "gradients.h"

#include <cstddef>
#include <cstdint>

namespace fresco::optimize
{
namespace
{

torch::Tensor shown(const ValueSpace& space, const torch::Tensor& stored)
{
    if (!space.is_network())
        return stored;
    auto values = stored.flip(0);
    for (std::size_t c = 0; c < 3; ++c)
        values.select(0, static_cast<std::int64_t>(c)).add_(space.offset(c));
    return values.div_(255);
}

}  // namespace

DisplayedValues displayed_values(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& hidden)
{
    const auto values = shown(space, stored);
    if (!space.is_clamped())
        return {values.masked_fill(hidden, 0), {}};
    auto picture = values.clamp(0, 1);
    const auto beyond = values - picture;
    return {picture.masked_fill_(hidden, 0), beyond};
}

torch::Tensor values_back(const ValueSpace& space, const torch::Tensor& beyond, const torch::Tensor& factor,
                          const torch::Tensor& gradient)
{
    auto result = gradient * factor;
    // A step against the gradient leads on where that has the other sign.
    if (beyond.defined())
        result.masked_fill_(beyond * gradient < 0, 0);
    return space.is_network() ? result.mul_(space.scale()).flip(0) : result;
}

}  // namespace fresco::optimize
