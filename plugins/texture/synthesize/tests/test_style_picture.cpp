#include "catch.h"
#include "samples.h"
#include "style_picture.h"

#include <fresco/error.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>
#include <fresco/testing_scenes.h>

using namespace samples;

TEST_CASE("a picture without contrast, or smaller than a patch, is refused by name")
{
    testing::TestRun run;
    struct Case
    {
        int width, height;
        double scale;
        int side;
        const char* text;
    };
    for (const Case& c : {Case{64, 64, 1, 11, "a single color"}, Case{64, 64, 0.5, 31, "a single color"},
                          Case{64, 64, 0.1, 11, "a single color"}})
        CHECK_THROWS_WITH(StylePicture(Raster8(c.width, c.height, 3, 90), c.scale, c.side, run), Catch::Contains(c.text));
    for (const Case& c : {Case{10, 64, 1, 11, "10x64"}, Case{64, 10, 1, 11, "64x10"}, Case{64, 64, 0.15, 11, "64x64"}})
        CHECK_THROWS_WITH(StylePicture(brush_picture(c.width, c.height, 1), c.scale, c.side, run),
                          Catch::Contains(c.text) && Catch::Contains("smaller than one patch of 11"));
}

TEST_CASE("a picture of just one patch, or whose keys are all alike, has contrast enough")
{
    testing::TestRun run;
    const StylePicture single(brush_picture(11, 11, 1), 1, 11, run);
    CHECK(single.key_count() == 1);
    CHECK(single.key(0) == Vec2f{5, 5});
    Raster8 checkers(40, 40, 3);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x)
            for (int c = 0; c < 3; ++c)
                checkers.at(x, y, c) = (x + y) % 2 == 0 ? 40 : 220;
    const StylePicture level(checkers, 1, 5, run);
    for (const float v : level.key_features())
        CHECK(std::isfinite(v));
}

TEST_CASE("keys are a regular grid of whole patches, at most twelve thousand")
{
    testing::TestRun run(2);
    struct Case
    {
        int width, height;
        double scale;
        int side;
    };
    for (const Case& c : {Case{60, 40, 1, 11}, Case{61, 41, 1, 5}, Case{300, 260, 1, 5}, Case{900, 90, 0.5, 7},
                          Case{50, 40, 2, 7}, Case{400, 700, 1, 3}})
    {
        CAPTURE(c.width, c.height, c.scale, c.side);
        const StylePicture level(brush_picture(c.width, c.height, 1), c.scale, c.side, run);
        CHECK(level.lab().width == static_cast<int>(std::lround(c.width * c.scale)));
        CHECK(level.lab().height == static_cast<int>(std::lround(c.height * c.scale)));
        CHECK(level.key_count() <= StylePicture::most_keys);
        CHECK(level.key_features().size() == level.key_count() * level.feature_count());
        const auto half = static_cast<float>(c.side / 2);
        std::size_t outside = 0;
        float largest_step = 0;
        for (std::size_t k = 0; k < level.key_count(); ++k)
        {
            const Vec2f at = level.key(k);
            outside += at.x < half || at.y < half || at.x > static_cast<float>(level.lab().width - 1) - half ||
                       at.y > static_cast<float>(level.lab().height - 1) - half;
            outside += at.x != std::floor(at.x) || at.y != std::floor(at.y) || level.inside(at) != at;
            if (k > 0 && level.key(k - 1).y == at.y)
                largest_step = std::max(largest_step, at.x - level.key(k - 1).x);
        }
        CHECK(outside == 0);
        // As many as fit: every second pixel, or so many that one more column would be too much.
        if (level.key_count() < 9000)
            CHECK(largest_step == 2);
        // From one key to the next there is no pixel that neither reaches.
        CHECK(2 * level.key_reach() + 1 >= static_cast<int>(largest_step));
        const Vec2f last = level.key(level.key_count() - 1);
        CHECK(static_cast<float>(level.lab().width - 1) - half - last.x <= largest_step);
        CHECK(static_cast<float>(level.lab().height - 1) - half - last.y <= largest_step);
    }
}

TEST_CASE("the key near a position is the nearest")
{
    testing::TestRun run;
    Random random(8);
    for (const int width : {40, 230, 320})
    {
        CAPTURE(width);
        const StylePicture level(brush_picture(width, 240, 1), 1, 5, run);
        double worst = 0;
        for (int i = 0; i < 300; ++i)
        {
            const Vec2f at{static_cast<float>(random.uniform() * width), static_cast<float>(random.uniform() * 240)};
            const auto away = [&](std::size_t key) { return static_cast<double>(length(level.key(key) - at)); };
            double least = 1e9;
            for (std::size_t k = 0; k < level.key_count(); ++k)
                least = std::min(least, away(k));
            worst = std::max(worst, away(level.key_near(at)) - least);
        }
        CHECK(worst < 1e-5);
    }
}

TEST_CASE("no patch lies on a transparent pixel, and the key near a position is the nearest of those that are left")
{
    testing::TestRun run;
    Random random(9);
    const Raster8 rgb = brush_picture(120, 100, 1);
    Raster8 opaque(120, 100, 1, 255);
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 120; ++x)
            if (std::hypot(x - 60, y - 40) < 25 || y == 90)
                opaque.at(x, y) = 0;
    for (const double stroke_px : {0.0, 6.0})
        for (const double scale : {1.0, 0.5})
        {
            CAPTURE(stroke_px, scale);
            const StylePicture all(rgb, scale, 5, run, stroke_px);
            const StylePicture part(rgb, scale, 5, run, stroke_px, opaque);
            CHECK(part.key_count() < all.key_count());
            CHECK(part.key_features().size() == part.key_count() * part.feature_count());
            // A turned patch reaches farther.
            const int reach = stroke_px > 0 ? 3 : 2;
            const auto is_opaque = [&](Vec2f at)
            {
                for (int y = 0; y < 100; ++y)
                    for (int x = 0; x < 120; ++x)
                        if (opaque.at(x, y) == 0 && std::abs((x + 0.5) * scale - 0.5 - at.x) <= reach &&
                            std::abs((y + 0.5) * scale - 0.5 - at.y) <= reach)
                            return false;
                return true;
            };
            std::size_t wrong = 0;
            for (std::size_t k = 0; k < part.key_count(); ++k)
                wrong += !is_opaque(part.key(k)) || !part.has_patch(part.key(k)) || part.key_near(part.key(k)) != k;
            // No opaque patch is missing that lies a pixel farther from transparent ones.
            std::size_t found = 0;
            for (std::size_t k = 0; k < all.key_count(); ++k)
                found += part.has_patch(all.key(k));
            CHECK(found == part.key_count());
            CHECK(wrong == 0);
            for (int i = 0; i < 100; ++i)
            {
                const Vec2f at = part.inside({static_cast<float>(random.uniform() * part.lab().width),
                                              static_cast<float>(random.uniform() * part.lab().height)});
                if (part.has_patch(at))
                    wrong += !is_opaque(at);
            }
            CHECK(wrong == 0);
            CHECK(all.has_patch(all.inside({60, 40})));
            CHECK(part.opaque_count(0, 0, part.lab().width, part.lab().height) <
                  all.opaque_count(0, 0, all.lab().width, all.lab().height));
        }
    CHECK_THROWS_WITH(StylePicture(rgb, 1, 5, run, 0, Raster8(120, 100, 1, 254)), Catch::Contains("no opaque part"));
}

namespace
{

/// Stripes, each `width_px` wide: as soft as a sine, or hard-edged.
Raster8 stripes(int width, int height, double width_px, double degrees, bool is_hard = false)
{
    const double angle = degrees * std::numbers::pi / 180;
    const auto value = [=](int x, int y, int)
    {
        const double wave = std::sin(std::numbers::pi * (x * std::cos(angle) + y * std::sin(angle)) / width_px);
        return 128 + 80 * (is_hard ? std::copysign(1.0, wave) : wave);
    };
    return testing::picture(width, height, value);
}

/// Each pixel four times.
Raster8 doubled(const Raster8& picture)
{
    return testing::picture(2 * picture.width, 2 * picture.height,
                            [&](int x, int y, int c) { return picture.at(x / 2, y / 2, c); });
}

}  // namespace

TEST_CASE("a shift makes up for three quarters of a gap, and for no more than its limit")
{
    CHECK(length(shift_for({8, 0, 0}) - Vec3f{6, 0, 0}) < 1e-5F);
    CHECK(squared_gap({8, 0, 0}) == Approx(16));  // 2² left, and a third of 6².
    CHECK(length(shift_for({0, -24, 32}) - Vec3f{0, -8.4F, 11.2F}) < 1e-5F);
    CHECK(squared_gap({0, -24, 32}) == Approx(26.0 * 26 + 14.0 * 14 / 3));
    CHECK(squared_gap({}) == 0);
}

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
    CHECK(stroke_width_px(testing::noise_picture(200, 200, 9), run) <= 3);
    CHECK(stroke_width_px(doubled(testing::noise_picture(100, 100, 9)), run) <= 5);
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
