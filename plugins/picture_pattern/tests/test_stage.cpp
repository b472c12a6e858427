#include "catch.h"
#include "pattern.h"

#include <fresco/error.h>
#include <fresco/image.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <cmath>
#include <stdexcept>

using fresco::testing::TestRun;
using pattern::Vec2f;
using pattern::Vec3f;

namespace
{

constexpr pattern::BrushOptions brush{.size_px = 128, .stroke_share = 0.05f, .stroke_length = 7, .seed = 4};

fresco::Raster8 make(const fresco::Value& options)
{
    const fresco::testing::TemporaryFolder out;
    TestRun run;
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "picture.pattern", options, {}, out.path(), run);
    return fresco::Image::load({out.path() / "picture", {}})->pixels;
}

fresco::Value small(const char* kind, const char* palette = "night", int seed = 1)
{
    return fresco::Value::Map{{"kind", kind}, {"palette", palette}, {"size_px", 96}, {"seed", seed}};
}

/// Mean absolute difference of neighbors along x and along y.
std::pair<double, double> roughness(const fresco::Raster8& picture)
{
    double across = 0, down = 0;
    for (int y = 0; y + 1 < picture.height; ++y)
        for (int x = 0; x + 1 < picture.width; ++x)
        {
            across += std::abs(picture.at(x + 1, y, 1) - picture.at(x, y, 1));
            down += std::abs(picture.at(x, y + 1, 1) - picture.at(x, y, 1));
        }
    const double count = (picture.width - 1.0) * (picture.height - 1.0);
    return {across / count, down / count};
}

double difference(const fresco::Raster8& a, const fresco::Raster8& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i)
        sum += std::abs(a.values[i] - b.values[i]);
    return sum / static_cast<double>(a.values.size());
}

/// Gray everywhere, brushed in one direction.
struct EvenMotif final : pattern::Motif
{
    explicit EvenMotif(float angle) : angle_(angle) {}
    Vec3f color(Vec2f) const override { return {0.5f, 0.5f, 0.5f}; }
    float direction(Vec2f) const override { return angle_; }
    float angle_;
};

}  // namespace

TEST_CASE("kinds, palettes and seeds are clearly different", "[picture.pattern]")
{
    const auto strokes = make(small("strokes"));
    CHECK(strokes.width == 96);
    CHECK(strokes.height == 96);
    CHECK(strokes.channels == 3);
    for (const char* kind : {"waves", "mosaic"})
        CHECK(difference(strokes, make(small(kind))) > 20);
    for (const char* palette : {"meadow", "ember", "sea"})
        CHECK(difference(strokes, make(small("strokes", palette))) > 20);
    CHECK(difference(strokes, make(small("strokes", "night", 2))) > 8);
}

TEST_CASE("strokes follow the direction of the motif", "[picture.pattern]")
{
    TestRun run;
    const auto lying = roughness(pattern::paint(EvenMotif(0), brush, run));
    const auto standing = roughness(pattern::paint(EvenMotif(1.5707963f), brush, run));
    CHECK(lying.second > 1.5 * lying.first);
    CHECK(standing.first > 1.5 * standing.second);
}

TEST_CASE("a mosaic has the asked number of stones across", "[picture.pattern]")
{
    TestRun run;
    const int stones = 8;
    const auto picture = pattern::lay_mosaic(EvenMotif(0), 256, stones, 1, run);
    // Along a row, grout (dark) and stone alternate: count the entries into grout.
    double entries = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 1; x < picture.width; ++x)
            entries += picture.at(x, y) < 80 && picture.at(x - 1, y) >= 80 ? 1 : 0;
    CHECK(entries / picture.height > 0.7 * stones);
    CHECK(entries / picture.height < 1.4 * stones);
}

TEST_CASE("whirls turn the brush around their center", "[picture.pattern]")
{
    const pattern::SwirlingSky sky(pattern::palette_named("night"), 1);
    // Around the large whirl at about (0.3, 0.36) the direction turns by one full circle.
    double turned = 0;
    float before = sky.direction({0.40f, 0.36f});
    for (int i = 1; i <= 72; ++i)
    {
        const float angle = 6.2831853f * static_cast<float>(i) / 72;
        const float now = sky.direction({0.30f + 0.10f * std::cos(angle), 0.36f + 0.10f * std::sin(angle)});
        turned += static_cast<double>(std::remainder(now - before, 6.2831853f));
        before = now;
    }
    CHECK(std::abs(turned) == Approx(6.2831853).epsilon(0.01));
}

TEST_CASE("unknown words and sizes are refused, and painting can be stopped", "[picture.pattern]")
{
    CHECK_THROWS_AS(make(small("etching")), fresco::Error);
    CHECK_THROWS_AS(make(small("waves", "neon")), fresco::Error);
    CHECK_THROWS_AS(make(fresco::Value::Map{{"size_px", 8}}), fresco::Error);
    CHECK_THROWS_AS(pattern::palette_named("neon"), std::invalid_argument);
    TestRun run;
    run.cancel_after(3);
    CHECK_THROWS_AS(pattern::paint(EvenMotif(0), brush, run), fresco::Canceled);
    run.cancel_after(2);
    CHECK_THROWS_AS(pattern::lay_mosaic(EvenMotif(0), 128, 8, 1, run), fresco::Canceled);
}
