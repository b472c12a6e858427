#include "crops.h"

#include "catch.h"

#include <fresco/numerics/noise.h>

#include <array>

using namespace fresco;
using namespace fresco::optimize;

namespace
{

/// How often each pixel is in a core.
std::vector<int> held(const std::vector<Crop>& crops, int width, int height)
{
    std::vector<int> counts(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    for (const auto& crop : crops)
        for (int y = crop.core.y0; y < crop.core.y1; ++y)
            for (int x = crop.core.x0; x < crop.core.x1; ++x)
                ++counts[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    return counts;
}

}  // namespace

TEST_CASE("two spots far apart are two crops with their margins")
{
    Raster8 mask(100, 60);
    mask.at(10, 10) = 1;
    mask.at(11, 12) = 1;
    mask.at(90, 50) = 1;
    const auto crops = covering_crops(mask, 4, 6);
    REQUIRE(crops.size() == 2);
    CHECK((crops[0].core == PixelBox{8, 8, 12, 16}));
    CHECK((crops[0].encoded == PixelBox{0, 0, 20, 24}));  // 6 px become 8, a multiple of 4
    CHECK((crops[1].core == PixelBox{88, 48, 92, 52}));
    CHECK((crops[1].encoded == PixelBox{80, 40, 100, 60}));
}

TEST_CASE("a full mask is one frame, an empty one nothing, a half one half")
{
    const PixelBox frame{0, 0, 50, 30};
    const auto full = covering_crops(Raster8(50, 30, 1, 1), 8, 3);
    REQUIRE(full.size() == 1);
    CHECK((full[0].core == frame));
    CHECK((full[0].encoded == frame));
    CHECK(covering_crops(Raster8(50, 30), 8, 3).empty());
    Raster8 left(50, 30);
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 20; ++x)
            left.at(x, y) = 1;
    const auto half = covering_crops(left, 8, 3);
    REQUIRE(half.size() == 1);
    CHECK((half[0].core == PixelBox{0, 0, 24, 30}));
    CHECK((half[0].encoded == PixelBox{0, 0, 32, 30}));
}

TEST_CASE("cores hold every pixel of the mask once, aligned, and with their margin inside what is encoded")
{
    for (std::uint32_t seed = 0; seed < 30; ++seed)
    {
        CAPTURE(seed);
        const int width = 40 + static_cast<int>(seed) * 3;
        const int height = 33 + static_cast<int>(seed % 7) * 5;
        Raster8 mask(width, height);
        for (std::uint32_t blob = 0; blob < 4; ++blob)
        {
            const int cx = static_cast<int>(noise::unit(seed, 10 * blob) * static_cast<float>(width));
            const int cy = static_cast<int>(noise::unit(seed, 10 * blob + 1) * static_cast<float>(height));
            const int radius = static_cast<int>(noise::unit(seed, 10 * blob + 2) * 8);
            for (int y = std::max(0, cy - radius); y < std::min(height, cy + radius + 1); ++y)
                for (int x = std::max(0, cx - radius); x < std::min(width, cx + radius + 1); ++x)
                    mask.at(x, y) = 1;
        }
        const int align = seed % 2 == 0 ? 4 : 8;
        const int margin = static_cast<int>(seed % 11);
        const auto crops = covering_crops(mask, align, margin);
        const auto counts = held(crops, width, height);
        std::int64_t encoded = 0;
        for (std::size_t i = 0; i < counts.size(); ++i)
            CHECK((counts[i] == 1 || (counts[i] == 0 && mask.values[i] == 0)));
        for (const auto& [core, box] : crops)
        {
            encoded += box.area();
            for (const auto& [begin, end, whole, outer_begin, outer_end] :
                 {std::array{core.x0, core.x1, width, box.x0, box.x1}, std::array{core.y0, core.y1, height, box.y0, box.y1}})
            {
                CHECK(begin % align == 0);
                CHECK((end % align == 0 || end == whole));
                CHECK(outer_begin % align == 0);
                CHECK((outer_begin == 0 || begin - outer_begin >= margin));
                CHECK((outer_end == whole || outer_end - end >= margin));
            }
        }
        CHECK(encoded <= static_cast<std::int64_t>(width) * height);
    }
}
