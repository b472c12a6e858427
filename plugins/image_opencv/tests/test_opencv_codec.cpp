#include "catch.h"
#include "opencv_codec.h"

#include <cmath>

using fresco::Raster16;
using fresco::Raster8;
using namespace image_opencv;

namespace
{

template <class T>
fresco::Raster<T> row(int channels, std::vector<T> values)
{
    fresco::Raster<T> raster(static_cast<int>(values.size()) / channels, 1, channels);
    raster.values = std::move(values);
    return raster;
}

}  // namespace

TEST_CASE("Convert: alpha is composited on white, rounded to the nearest")
{
    for (int color = 0; color < 256; ++color)
        for (int alpha = 0; alpha < 256; ++alpha)
        {
            const auto c = static_cast<std::uint8_t>(color);
            const auto out = to_rgb(row<std::uint8_t>(4, {c, 0, 255, static_cast<std::uint8_t>(alpha)}));
            const auto expected = [&](double v) { return std::lround((v * alpha + 255.0 * (255 - alpha)) / 255.0); };
            REQUIRE(out.values[0] == expected(color));
            REQUIRE(out.values[1] == 255 - alpha);
            REQUIRE(out.values[2] == 255);
        }
}

TEST_CASE("Convert: gray is repeated, RGB stays, 16 bits are divided by 257")
{
    CHECK(to_rgb(row<std::uint8_t>(1, {0, 9})).values == std::vector<std::uint8_t>{0, 0, 0, 9, 9, 9});
    CHECK(to_rgb(row<std::uint8_t>(3, {1, 2, 3})).values == std::vector<std::uint8_t>{1, 2, 3});
    CHECK(to_rgb(row<std::uint16_t>(3, {0, 65535, 257 * 100 + 128})).values == std::vector<std::uint8_t>{0, 255, 100});
    CHECK(to_rgb(row<std::uint16_t>(3, {129, 128, 65406})).values == std::vector<std::uint8_t>{1, 0, 254});
    CHECK(to_rgb(row<std::uint16_t>(4, {0, 65535, 257 * 10, 32768})).values == std::vector<std::uint8_t>{127, 255, 132});
    CHECK(to_rgb(row<std::uint16_t>(4, {65535, 65535, 65535, 65535})).values == std::vector<std::uint8_t>{255, 255, 255});
}

TEST_CASE("Convert: alpha that is kept leaves colors as they are")
{
    const auto bytes = row<std::uint8_t>(4, {1, 2, 3, 0, 4, 5, 6, 128});
    CHECK(to_rgba(bytes) == bytes);
    CHECK(to_rgba(row<std::uint16_t>(4, {0, 65535, 129, 128})).values == std::vector<std::uint8_t>{0, 255, 1, 0});
}

TEST_CASE("Convert: a gray color key becomes white")
{
    CHECK(to_rgb(row<std::uint8_t>(1, {7, 9}), 7).values == std::vector<std::uint8_t>{255, 255, 255, 9, 9, 9});
    CHECK(to_rgb(row<std::uint16_t>(1, {257, 514}), 514).values == std::vector<std::uint8_t>{1, 1, 1, 255, 255, 255});
}

TEST_CASE("Convert: the eight orientations")
{
    // The letter-like pattern  1 2 3 / 4 5 6  as stored; expected as EXIF defines where row 0 and column 0 belong.
    Raster8 stored(3, 2, 1);
    stored.values = {1, 2, 3, 4, 5, 6};
    const std::vector<std::vector<std::uint8_t>> expected{{1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1},
                                                          {4, 5, 6, 1, 2, 3}, {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3},
                                                          {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
    for (int orientation = 1; orientation <= 8; ++orientation)
    {
        INFO(orientation);
        const auto shown = oriented(stored, orientation);
        CHECK(shown.width == (orientation < 5 ? 3 : 2));
        CHECK(shown.height == (orientation < 5 ? 2 : 3));
        CHECK(shown.values == expected[static_cast<std::size_t>(orientation - 1)]);
    }
    Raster8 colors(2, 1, 3);
    colors.values = {1, 2, 3, 4, 5, 6};
    CHECK(oriented(colors, 2).values == std::vector<std::uint8_t>{4, 5, 6, 1, 2, 3});
}
