#include "catch.h"
#include "plugin_under_test.h"
#include "samples.h"

#include <fresco/error.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>

using namespace samples;

TEST_CASE_METHOD(testing::StageTest, "a picture without contrast, or smaller than a patch, is refused by name")
{
    for (const double scale : {1.0, 0.5})
        CHECK_THROWS_WITH(StylePicture(Raster8(64, 64, 3, 90), scale, 11, run), Catch::Contains("a single color"));
    for (const auto& [width, height, scale] : {std::tuple(10, 64, 1.0), std::tuple(64, 10, 1.0), std::tuple(64, 64, 0.15)})
        CHECK_THROWS_WITH(StylePicture(brush_picture(width, height, 1), scale, 11, run),
                          Catch::Contains(std::to_string(width) + "x" + std::to_string(height)) &&
                              Catch::Contains("smaller than one patch of 11"));
    // Just one patch, or keys that are all alike, are enough.
    const StylePicture single(brush_picture(11, 11, 1), 1, 11, run);
    CHECK(single.key_count() == 1);
    CHECK(single.key(0) == Vec2f{5, 5});
    const StylePicture checkers(testing::checkerboard(40, 40, 1, 40, 220), 1, 5, run);
    CHECK(std::ranges::all_of(checkers.key_features(), [](float v) { return std::isfinite(v); }));
}

TEST_CASE_METHOD(testing::StageTest,
                 "keys are a regular grid of whole patches, at most eight thousand, and the nearest to a position is found")
{
    Random random(8);
    struct Case
    {
        int width, height;
        double scale;
        int side;
    };
    for (const Case& c : {Case{61, 41, 1, 11}, Case{300, 260, 1, 5}, Case{900, 90, 0.5, 7}, Case{50, 40, 2, 7}})
    {
        CAPTURE(c.width, c.height, c.scale, c.side);
        const StylePicture level(brush_picture(c.width, c.height, 1), c.scale, c.side, run);
        const int width = level.lab().width;
        const int height = level.lab().height;
        CHECK(width == static_cast<int>(std::lround(c.width * c.scale)));
        CHECK(height == static_cast<int>(std::lround(c.height * c.scale)));
        CHECK(level.key_count() <= StylePicture::most_keys);
        CHECK(level.key_features().size() == level.key_count() * level.feature_count());
        const auto half = static_cast<float>(c.side / 2);
        std::size_t outside = 0;
        float largest_step = 0;
        for (std::size_t k = 0; k < level.key_count(); ++k)
        {
            const Vec2f at = level.key(k);
            outside += at.x < half || at.y < half || at.x > static_cast<float>(width - 1) - half ||
                       at.y > static_cast<float>(height - 1) - half;
            outside += at.x != std::floor(at.x) || at.y != std::floor(at.y) || level.inside(at) != at;
            if (k > 0 && level.key(k - 1).y == at.y)
                largest_step = std::max(largest_step, at.x - level.key(k - 1).x);
        }
        CHECK(outside == 0);
        // As many as fit: every second pixel, or so many that one more column would be too much.
        if (level.key_count() < 6000)
            CHECK(largest_step == 2);
        // From one key to the next there is no pixel that neither reaches.
        CHECK(2 * level.key_reach() + 1 >= static_cast<int>(largest_step));
        const Vec2f last = level.key(level.key_count() - 1);
        CHECK(static_cast<float>(width - 1) - half - last.x <= largest_step);
        CHECK(static_cast<float>(height - 1) - half - last.y <= largest_step);
        float worst = 0;
        for (int i = 0; i < 100; ++i)
        {
            const Vec2f at{static_cast<float>(random.uniform() * width), static_cast<float>(random.uniform() * height)};
            float least = 1e9F;
            for (std::size_t k = 0; k < level.key_count(); ++k)
                least = std::min(least, length(level.key(k) - at));
            worst = std::max(worst, length(level.key(level.key_near(at)) - at) - least);
        }
        CHECK(worst < 1e-4F);
    }
}

TEST_CASE_METHOD(testing::StageTest, "features are as far apart as patches whose mean color counts half")
{
    // Three of 27 components are left out, which hold next to nothing.
    const StylePicture level(brush_picture(56, 48, 11), 1, 3, run);
    const std::size_t count = level.feature_count();
    REQUIRE(count == 24);
    const auto feature = [&](std::size_t key, std::size_t f) { return double{level.key_features()[key * count + f]}; };
    const auto colors = [&](std::size_t key)
    {
        std::array<Vec3f, 9> result;
        level.turned_patch(level.key(key), {1, 0}, &result[0].x);
        return result;
    };
    for (std::size_t k = 1; k < level.key_count(); k += 7)
    {
        const auto a = colors(k);
        const auto b = colors(k / 2);
        Vec3f mean;
        for (std::size_t i = 0; i < 9; ++i)
            mean += (a[i] - b[i]) * (1.0F / 9);
        double expected = 0;
        for (std::size_t i = 0; i < 9; ++i)
            expected += double{dot(a[i] - b[i] - mean * 0.5F, a[i] - b[i] - mean * 0.5F)};
        double found = 0;
        for (std::size_t f = 0; f < count; ++f)
            found += std::pow(feature(k, f) - feature(k / 2, f), 2);
        CHECK(found == Approx(expected).epsilon(0.01).margin(1));
    }
}

TEST_CASE("a picture's colors are bilinear, and those at its border go on beyond it")
{
    const Raster8 picture = testing::picture(2, 2, [](int x, int y, int c) { return 100 * x + 40 * y + c; });
    const ColorLookup<std::uint8_t> colors(picture);
    CHECK(colors({0.25F, 0.5F}) == Vec3f{45, 46, 47});
    CHECK(colors({-3, 9}) == Vec3f{40, 41, 42});
}

TEST_CASE_METHOD(testing::StageTest,
                 "no patch lies on a transparent pixel, and the key near a position is the nearest of those that are left")
{
    Random random(9);
    const Raster8 rgb = brush_picture(120, 100, 1);
    const Raster8 opaque = testing::picture(
        120, 100, [](int x, int y, int) { return std::hypot(x - 60, y - 40) < 25 || y == 90 ? 0 : 255; }, 1);
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
            for (int i = 0; i < 100; ++i)
            {
                const Vec2f at = part.inside({static_cast<float>(random.uniform() * part.lab().width),
                                              static_cast<float>(random.uniform() * part.lab().height)});
                wrong += part.has_patch(at) && !is_opaque(at);
            }
            CHECK(wrong == 0);
        }
    CHECK_THROWS_WITH(StylePicture(rgb, 1, 5, run, 0, Raster8(120, 100, 1, 254)), Catch::Contains("no opaque part"));
}

TEST_CASE("a shift makes up for three quarters of a gap, and for no more than its limit")
{
    CHECK(length(shift_for({8, 0, 0}) - Vec3f{6, 0, 0}) < 1e-5F);
    CHECK(squared_gap({8, 0, 0}) == Approx(16));  // 2² left, and a third of 6².
    CHECK(length(shift_for({0, -24, 32}) - Vec3f{0, -8.4F, 11.2F}) < 1e-5F);
    CHECK(squared_gap({0, -24, 32}) == Approx(26.0 * 26 + 14.0 * 14 / 3));
    CHECK(squared_gap({}) == 0);
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

TEST_CASE_METHOD(testing::StageTest,
                 "the stroke width of stripes is theirs at any angle and size, that of strokes their width, not their length")
{
    for (const double width : {4.0, 7.0, 10.0})
        for (const double degrees : {0.0, 20.0, 45.0, 90.0, 133.0})
        {
            CAPTURE(width, degrees);
            CHECK(stroke_width_px(stripes(180, 170, width, degrees), run) == Approx(width).epsilon(0.15));
            CHECK(stroke_width_px(stripes(180, 170, width, degrees, true), run) == Approx(0.75 * width).epsilon(0.15));
        }
    // Measured at a smaller size.
    CHECK(stroke_width_px(stripes(1100, 240, 12, 30), run) == Approx(12).epsilon(0.15));
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

TEST_CASE_METHOD(testing::StageTest, "noise has the narrowest strokes, and any picture some")
{
    CHECK(stroke_width_px(testing::noise_picture(200, 200, 9), run) <= 3);
    CHECK(stroke_width_px(doubled(testing::noise_picture(100, 100, 9)), run) <= 5);
    for (const int size : {1, 2, 30, 200})
        CHECK(stroke_width_px(Raster8(size, size, 3, 77), run) >= 2);
    CHECK(std::isfinite(stroke_width_px(brush_picture(400, 3, 1), run)));
    run.cancel_after(2);
    CHECK_THROWS_AS(stroke_width_px(brush_picture(150, 120, 2), run), Canceled);
}
