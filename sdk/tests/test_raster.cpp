#include "catch.h"

#include <fresco/image.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

using namespace fresco;

namespace
{

/// Value of one target coordinate along one axis, straight from the definition: the mean over the footprint when shrinking, the
/// tent between neighboring centers when enlarging.
double axis_weight(int target, int source, int from, int to)
{
    const double scale = static_cast<double>(from) / to;
    if (scale > 1)
    {
        const double overlap =
            std::min((target + 1) * scale, source + 1.0) - std::max(target * scale, static_cast<double>(source));
        return std::max(0.0, overlap) / scale;
    }
    const double center = std::clamp((target + 0.5) * scale - 0.5, 0.0, from - 1.0);
    return std::max(0.0, 1 - std::abs(center - source));
}

Raster<float> slow_resized(const Raster<float>& source, int width, int height)
{
    Raster<float> result(width, height, source.channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < source.channels; ++c)
            {
                double sum = 0;
                for (int v = 0; v < source.height; ++v)
                    for (int u = 0; u < source.width; ++u)
                        sum += axis_weight(x, u, source.width, width) * axis_weight(y, v, source.height, height) *
                               static_cast<double>(source.at(u, v, c));
                result.at(x, y, c) = static_cast<float>(sum);
            }
    return result;
}

Raster<float> ramp(int width, int height, int channels)
{
    Raster<float> raster(width, height, channels);
    for (std::size_t i = 0; i < raster.values.size(); ++i)
        raster.values[i] = static_cast<float>((i * 7919) % 1000) / 10.0F;
    return raster;
}

}  // namespace

TEST_CASE("resized: equals the definition for any sizes", "[raster]")
{
    for (const auto& [width, height] : {std::pair{5, 4}, std::pair{9, 3}, std::pair{1, 6}})
        for (const int channels : {1, 3, 5})
        {
            const auto source = ramp(width, height, channels);
            for (const int w : {1, 2, 3, 7, 9, 16})
                for (const int h : {1, 2, 4, 5, 11})
                {
                    INFO(width << 'x' << height << " to " << w << 'x' << h);
                    const auto fast = resized(source, w, h);
                    const auto slow = slow_resized(source, w, h);
                    REQUIRE(fast.width == w);
                    REQUIRE(fast.height == h);
                    REQUIRE(fast.values.size() == slow.values.size());
                    for (std::size_t i = 0; i < slow.values.size(); ++i)
                        CHECK(fast.values[i] == Approx(slow.values[i]).margin(1e-4));
                }
        }
}

TEST_CASE("resized: bytes are rounded to the nearest, not cut", "[raster]")
{
    Raster<std::uint8_t> source(4, 1);
    source.values = {0, 0, 0, 3};
    CHECK(resized(source, 1, 1).values == std::vector<std::uint8_t>{1});  // 0.75
    source.values = {255, 255, 255, 254};
    CHECK(resized(source, 1, 1).values == std::vector<std::uint8_t>{255});  // 254.75
}

TEST_CASE("resized: refuses an empty picture and a size below 1", "[raster]")
{
    const Raster<std::uint8_t> source(2, 2);
    CHECK_THROWS_AS(resized(Raster<std::uint8_t>(), 2, 2), std::invalid_argument);
    CHECK_THROWS_AS(resized(source, 0, 2), std::invalid_argument);
    CHECK_THROWS_AS(resized(source, 2, -1), std::invalid_argument);
    CHECK_THROWS_AS(resized(Raster<float>(), 1, 1), std::invalid_argument);
}
