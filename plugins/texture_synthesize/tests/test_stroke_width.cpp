#include "catch.h"
#include "samples.h"

#include <fresco/images/stroke_width.h>

using namespace samples;

namespace
{

/// Stripes, each `width_px` wide: as soft as a sine, or hard-edged.
Raster8 stripes(int width, int height, double width_px, double degrees, bool is_hard = false)
{
    Raster8 picture(width, height, 3);
    const double angle = degrees * std::numbers::pi / 180;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const double wave = std::sin(std::numbers::pi * (x * std::cos(angle) + y * std::sin(angle)) / width_px);
            const double value = 128 + 80 * (is_hard ? std::copysign(1.0, wave) : wave);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>(std::lround(value));
        }
    return picture;
}

/// Each pixel four times.
Raster8 doubled(const Raster8& picture)
{
    Raster8 result(2 * picture.width, 2 * picture.height, 3);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            for (int c = 0; c < 3; ++c)
                result.at(x, y, c) = picture.at(x / 2, y / 2, c);
    return result;
}

Raster8 noise_picture(int size)
{
    Random random(9);
    Raster8 picture(size, size, 3);
    for (std::uint8_t& v : picture.values)
        v = static_cast<std::uint8_t>(random.below(256));
    return picture;
}

}  // namespace

TEST_CASE("the stroke width of stripes is theirs, at any angle and size")
{
    testing::TestRun run;
    for (const double width : {4.0, 7.0, 10.0})
        for (const double degrees : {0.0, 20.0, 45.0, 90.0, 133.0})
        {
            CAPTURE(width, degrees);
            const Raster8 picture = stripes(180, 170, width, degrees);
            const double measured = stroke_width_px(picture, run);
            CHECK(measured == Approx(width).epsilon(0.15));
            CHECK(stroke_width_px(stripes(180, 170, width, degrees, true), run) == Approx(0.75 * width).epsilon(0.15));
            if (degrees == 20)
                CHECK(stroke_width_px(resized(picture, 360, 340), run) == Approx(2 * measured).epsilon(0.15));
        }
    // Measured at a smaller size.
    CHECK(stroke_width_px(stripes(1100, 240, 12, 30), run) == Approx(12).epsilon(0.15));
}

TEST_CASE("strokes count by their width, not their length")
{
    testing::TestRun run;
    for (const double width : {4.0, 6.0, 9.0})
    {
        CAPTURE(width);
        const Raster8 picture = brush_picture(160, 140, 4, width);
        const double measured = stroke_width_px(picture, run);
        CHECK(measured > 0.6 * width);
        CHECK(measured < 1.6 * width);
        CHECK(stroke_width_px(doubled(picture), run) == Approx(2 * measured).epsilon(0.15));
    }
}

TEST_CASE("noise has the narrowest strokes, and any picture some")
{
    testing::TestRun run;
    CHECK(stroke_width_px(noise_picture(200), run) <= 3);
    CHECK(stroke_width_px(doubled(noise_picture(100)), run) <= 5);
    for (const int size : {1, 2, 5, 30, 200})
        for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{77}, std::uint8_t{255}})
        {
            const double width = stroke_width_px(Raster8(size, size, 3, value), run);
            CHECK(std::isfinite(width));
            CHECK(width >= 2);
        }
    CHECK(std::isfinite(stroke_width_px(brush_picture(400, 3, 1), run)));
    testing::TestRun single(1);
    testing::TestRun five(5);
    const Raster8 picture = brush_picture(150, 120, 2);
    CHECK(stroke_width_px(picture, single) == stroke_width_px(picture, five));
    five.cancel_after(2);
    CHECK_THROWS_AS(stroke_width_px(picture, five), Canceled);
}
