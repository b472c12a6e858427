#pragma once

#include <fresco/random.h>

#include <ATen/ops/empty.h>

namespace fresco::testing
{

/// In [-0.5, 0.5).
inline at::Tensor random_tensor(at::IntArrayRef shape, std::uint64_t seed, at::ScalarType type = at::kFloat)
{
    Random random(seed);
    auto values = at::empty(shape, at::kDouble);
    for (std::int64_t i = 0; i < values.numel(); ++i)
        values.data_ptr<double>()[i] = random.uniform() - 0.5;
    return values.to(type);
}

}  // namespace fresco::testing
