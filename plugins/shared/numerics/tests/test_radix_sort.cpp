#include "catch.h"

#include <fresco/numerics/radix_sort.h>
#include <fresco/random.h>

#include <algorithm>
#include <limits>

using namespace fresco;
using namespace fresco::numerics;

TEST_CASE("entries are sorted by their upper half and keep their order where it is equal")
{
    Random random(3);
    for (const std::uint32_t largest : {0U, 5U, 2047U, 2048U, 1U << 23U, std::numeric_limits<std::uint32_t>::max()})
    {
        std::vector<std::uint64_t> entries;
        for (int i = 0; i < 3000; ++i)
            entries.push_back(random.bits() % (std::uint64_t{largest} + 1) << 32U | (random.bits() & 0xffffffffU));
        auto expected = entries;
        std::stable_sort(expected.begin(), expected.end(), [](auto a, auto b) { return a >> 32U < b >> 32U; });
        sort_by_upper_half(entries, largest);
        CHECK(entries == expected);
    }
}

TEST_CASE("keys of numbers are ordered as the numbers are")
{
    const float numbers[] = {-std::numeric_limits<float>::infinity(), -3e9F, -1.5F, -1e-40F, 0.0F, 1e-40F, 0.25F, 0.5F, 7.0F,
                             std::numeric_limits<float>::infinity()};
    for (std::size_t i = 1; i < std::size(numbers); ++i)
        CHECK(ordered_key(numbers[i - 1]) < ordered_key(numbers[i]));
}
