#include "catch.h"

#include <fresco/uv_mapping/cracks.h>

#include <limits>

using namespace fresco;

namespace
{
constexpr float none = std::numeric_limits<float>::infinity();

RasterF rows(int width, std::vector<float> depths)
{
    RasterF met(width, static_cast<int>(depths.size()) / width);
    met.values = std::move(depths);
    return met;
}
}  // namespace

TEST_CASE("a pixel more than 5 cm behind all eight neighbors is seen through a crack")
{
    CHECK(seen_through_crack(rows(3, {1, 1, 1, 1, 1.06F, 1, 1, 1, 1}), 1, 1));
    CHECK_FALSE(seen_through_crack(rows(3, {1, 1, 1, 1, 1.04F, 1, 1, 1, 1}), 1, 1));
    CHECK_FALSE(seen_through_crack(rows(3, {1, 1, 1, 1, 1, 1, 1, 1, 1}), 1, 1));
    // Before them.
    CHECK_FALSE(seen_through_crack(rows(3, {1, 1, 1, 1, 0.5F, 1, 1, 1, 1}), 1, 1));
}

TEST_CASE("one neighbor as deep, or that meets nothing, is enough to see past an edge")
{
    for (std::size_t i = 0; i < 9; ++i)
    {
        if (i == 4)
            continue;
        for (const float other : {1.97F, 5.0F, none})
        {
            RasterF met = rows(3, {1, 1, 1, 1, 2, 1, 1, 1, 1});
            met.values[i] = other;
            CHECK_FALSE(seen_through_crack(met, 1, 1));
        }
        RasterF met = rows(3, {1, 1, 1, 1, 2, 1, 1, 1, 1});
        met.values[i] = 1.94F;
        CHECK(seen_through_crack(met, 1, 1));
    }
}

TEST_CASE("the border of a picture and the void are no cracks")
{
    const RasterF met = rows(4, {9, 9, 9, 9, 9, none, 1, 9, 9, 9, 9, 9});
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x)
            CHECK_FALSE(seen_through_crack(met, x, y));
    CHECK_FALSE(seen_through_crack(rows(1, {1, 9, 1}), 0, 1));
}
