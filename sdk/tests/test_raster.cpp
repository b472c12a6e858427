#include "catch.h"
#include "random_numbers.h"

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

}  // namespace

TEST_CASE("resized: equals the definition for any sizes", "[raster]")
{
    for (const auto& [width, height] : {std::pair{5, 4}, std::pair{9, 3}, std::pair{1, 6}})
        for (const auto& [w, h] : {std::pair{1, 1}, {2, 4}, {3, 11}, {7, 2}, {9, 3}, {16, 5}})
        {
            INFO(width << 'x' << height << " to " << w << 'x' << h);
            RasterF source(width, height, 3);
            source.values = testing::random_numbers(source.values.size(), 1);
            const RasterF fast = resized(source, w, h);
            REQUIRE((fast.width == w && fast.height == h && fast.channels == 3));
            for (std::size_t i = 0; i < fast.values.size(); ++i)
            {
                const int x = static_cast<int>(i) / 3 % w;
                const int y = static_cast<int>(i) / 3 / w;
                double sum = 0;
                for (int v = 0; v < height; ++v)
                    for (int u = 0; u < width; ++u)
                        sum += axis_weight(x, u, width, w) * axis_weight(y, v, height, h) *
                               static_cast<double>(source.at(u, v, static_cast<int>(i % 3)));
                CHECK(fast.values[i] == Approx(sum).margin(1e-6));
            }
        }
}

TEST_CASE("resized: bytes are rounded to the nearest, not cut; nothing is made from nothing", "[raster]")
{
    Raster<std::uint8_t> source(4, 1);
    source.values = {0, 0, 0, 3};
    CHECK(resized(source, 1, 1).values == std::vector<std::uint8_t>{1});  // 0.75
    source.values = {255, 255, 255, 254};
    CHECK(resized(source, 1, 1).values == std::vector<std::uint8_t>{255});  // 254.75
    CHECK_THROWS_AS(resized(Raster<std::uint8_t>(), 2, 2), std::invalid_argument);
    CHECK_THROWS_AS(resized(source, 0, 2), std::invalid_argument);
}
