#pragma once

#include <fresco/random.h>

#include <cstddef>
#include <vector>

namespace fresco::testing
{

/// In [-0.5, 0.5).
inline std::vector<float> random_numbers(std::size_t count, std::uint64_t seed)
{
    Random random(seed);
    std::vector<float> values(count);
    for (auto& value : values)
        value = static_cast<float>(random.uniform() - 0.5);
    return values;
}

}  // namespace fresco::testing
