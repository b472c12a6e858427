#include "fakes.h"
#include "initial_texture.h"
#include "pictures.h"

#include "catch.h"

#include <fresco/error.h>
#include <fresco/images/lab.h>
#include <fresco/texture.h>

#include <cmath>

using namespace fakes;
using namespace fresco::optimize;

namespace
{

/// Start of a texture that a walk sees.
struct Walk
{
    testing::TemporaryFolder folder;
    Wall wall;
    ViewSource source{*wall.maps, wall.frames, nullptr, {}};

    Walk(std::size_t views, const std::vector<int>& heights) : wall(folder.path(), views, heights) {}

    InitialTexture begin(const RasterF& style, const InitialRules& rules, int threads = 2)
    {
        testing::TestRun run(threads);
        return initial_texture(source, source.seeing_views(), style, rules, run);
    }
};

Vec3d color_at(const RasterF& picture, int x, int y)
{
    return vec_cast<double>(Vec3f{picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)});
}

}  // namespace

TEST_CASE("the camera pictures gathered into the texture, recolored, have the style's colors where seen")
{
    Walk walk(9, {30});
    RasterF style(20, 20, 3);
    for (std::size_t i = 0; i < style.values.size(); ++i)
        style.values[i] = 0.35F + 0.01F * static_cast<float>(i * i % 19);
    const auto views = walk.source.seeing_views();
    REQUIRE(views.size() == 9);
    const auto texture = walk.begin(style, {Init::frames, 32});
    CHECK((walk.begin(style, {Init::frames, 32}, 3).picture == texture.picture));

    // The slow twin: the painting itself, mapped by the statistics of what the frames show.
    ColorMoments shown;
    ColorMoments wanted;
    for (std::size_t i = 0; i < style.values.size(); i += 3)
        wanted.add(vec_cast<double>(Vec3f{style.values[i], style.values[i + 1], style.values[i + 2]}));
    for (const auto view : views)
        for (int y = 0; y < 30; ++y)
            for (int x = 2; x < 40; ++x)
                shown.add(vec_cast<double>(seen_painting(view, 9, (x + 0.5) / 40, (y + 0.5) / 30)));
    const auto map = monge_kantorovich(shown, wanted);
    int compared = 0;
    for (int y = 1; y < 31; ++y)
        for (int x = 1; x < 31; ++x)
        {
            bool inside = true;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    inside = inside && texture.seen.at(x + dx, y + dy) != 0;
            if (!inside)
                continue;
            const auto expected = map(vec_cast<double>(painting((x + 0.5) / 32, 1 - (y + 0.5) / 32)));
            CHECK(length(color_at(texture.picture, x, y) - expected) < 0.03);
            ++compared;
        }
    CHECK(compared > 300);
    for (const float v : texture.picture.values)
        CHECK(v > 0.1F);
}

TEST_CASE("a texture begins with the style's mean color, or at zero, and is marked where seen either way")
{
    Walk walk(3, {24, 30});
    RasterF style(2, 1, 3);
    style.values = {0, 0.5F, 1, 1, 0.5F, 0};
    const auto zeros = walk.begin(style, {Init::zeros, 16});
    const auto color = walk.begin(style, {Init::color, 16});
    const auto frames = walk.begin(style, {Init::frames, 16});
    CHECK(zeros.picture.empty());
    CHECK(color.picture.values == std::vector<float>(16 * 16 * 3, 0.5F));
    CHECK((zeros.seen == color.seen));
    CHECK((zeros.seen == frames.seen));
    CHECK(zeros.seen.at(4, 8) == 1);
    CHECK(zeros.seen.at(15, 0) == 0);
}

TEST_CASE("a channel of the style that does not vary begins with its color as noise too")
{
    Walk walk(3, {30});
    for (int shade = 0; shade < 256; shade += 3)
    {
        RasterF style(64, 50, 3, static_cast<float>(shade) / 255);
        for (std::size_t i = 1; i < style.values.size(); i += 3)
            style.values[i] = static_cast<float>(i % 7) / 10;
        const auto noise = walk.begin(style, {Init::noise, 16, 5});
        REQUIRE(noise.picture.values.size() == 16 * 16 * 3);
        for (std::size_t i = 0; i < noise.picture.values.size(); ++i)
            CHECK(std::abs(noise.picture.values[i] - static_cast<float>(shade) / 255) < (i % 3 == 1 ? 2 : 1e-4F));
    }
}

namespace
{

/// One layer of which the left half was seen, with `rgb` on it; the right half is white.
Texture half_seen(int size_px, Vec3f rgb)
{
    Texture start = testing::blank_texture(size_px, 1);
    testing::see(start, {0, 0}, {0.5F, 1}, rgb);
    return start;
}

}  // namespace

TEST_CASE("a start texture of one color becomes the style's mean, whatever its size, and what was not seen of it does not count")
{
    Walk walk(3, {24, 30});
    RasterF style(2, 1, 3);
    style.values = {0.1F, 0.5F, 0.9F, 0.5F, 0.7F, 0.7F};
    const auto gathered = walk.begin(style, {Init::frames, 32});
    for (const int size_px : {16, 20, 32, 64, 70})
    {
        CAPTURE(size_px);
        const Texture start = half_seen(size_px, {0.2F, 0.4F, 0.3F});
        const auto texture = walk.begin(style, {Init::frames, 32, 0, &start});
        REQUIRE(texture.picture.width == 32);
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x)
                CHECK(length(color_at(texture.picture, x, y) - Vec3d{0.3, 0.6, 0.8}) < 2e-5);
        CHECK((texture.seen == gathered.seen));
    }
}

TEST_CASE("a start texture takes the style's mean and deviation, summed over its layers and where it is")
{
    Walk walk(3, {30});
    RasterF style(2, 1, 3);
    style.values = {0.4F, 0.5F, 0.5F, 0.6F, 0.5F, 0.5F};
    // Red is 0.25 above and 0.75 below: the first layer holds 0.5 of it below, the second 0.25 everywhere.
    Texture start;
    start.layers.emplace_back(16, 16, 3, 0.5F);
    start.layers.emplace_back(8, 8, 3, 0.0F);
    start.seen = Raster8(16, 16, 1, 1);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
            start.layers[0].at(x, y, 0) = y < 8 ? 0 : 0.5F;
    for (std::size_t i = 0; i < 64; ++i)
        start.layers[1].values[3 * i] = 0.25F;
    for (const int size_px : {16, 8, 32})
    {
        CAPTURE(size_px);
        const auto texture = walk.begin(style, {Init::frames, size_px, 0, &start});
        CHECK(texture.picture.at(0, 0, 0) == Approx(0.4).margin(size_px == 32 ? 0.01 : 1e-5));
        CHECK(texture.picture.at(size_px - 1, size_px - 1, 0) == Approx(0.6).margin(size_px == 32 ? 0.01 : 1e-5));
        CHECK(texture.picture.at(0, 0, 1) == Approx(0.5).margin(1e-5));
    }
}

TEST_CASE("a start texture that cannot be begun with is refused")
{
    Walk walk(3, {30});
    const RasterF style(2, 1, 3, 0.5F);
    const auto begin = [&](Init init, const Texture& start) { walk.begin(style, {init, 16, 0, &start}); };
    Texture start = half_seen(16, {0.2F, 0.4F, 0.3F});
    CHECK_THROWS_WITH(begin(Init::zeros, start), Catch::Contains("port 'start' is wired, but init is zeros"));
    start.values = "network";
    CHECK_THROWS_WITH(begin(Init::frames, start),
                      Catch::Contains("port 'start' holds \"network\" values; expected displayed colors"));
    start.values = "display";
    start.seen = Raster8(16, 16);
    CHECK_THROWS_WITH(begin(Init::frames, start), Catch::Contains("no texel that a frame saw"));
    start = half_seen(16, {0.2F, 0.4F, 0.3F});
    start.layers.front().values[5] = std::nanf("");
    CHECK_THROWS_WITH(begin(Init::frames, start), Catch::Contains("not finite"));
}

TEST_CASE("noise has the mean and the deviation asked for, structure of several sizes, and depends only on the seed")
{
    const auto picture = noise_picture(512, {0.5, 0.4, 0.6}, {0.1, 0.05, 0.02}, 7, 1);
    CHECK((noise_picture(512, {0.5, 0.4, 0.6}, {0.1, 0.05, 0.02}, 7, 3) == picture));
    CHECK_FALSE((noise_picture(512, {0.5, 0.4, 0.6}, {0.1, 0.05, 0.02}, 8, 1) == picture));
    // The mean and the deviation of red and green are those asked for, as is checked below.
    const auto correlation = [&](int distance, int b = 0)
    {
        double sum = 0;
        for (int y = 0; y < 512; ++y)
            for (int x = 0; x + distance < 512; ++x)
                sum += (picture.at(x, y, 0) - 0.5) * (picture.at(x + distance, y, b) - (b == 0 ? 0.5 : 0.4));
        return sum / (512.0 * (512 - distance) * 0.1 * (b == 0 ? 0.1 : 0.05));
    };
    ColorMoments moments;
    for (std::size_t i = 0; i < picture.values.size(); i += 3)
        moments.add({static_cast<double>(picture.values[i]), static_cast<double>(picture.values[i + 1]),
                     static_cast<double>(picture.values[i + 2])});
    CHECK(moments.mean().x == Approx(0.5).margin(0.01));
    CHECK(moments.mean().z == Approx(0.6).margin(0.005));
    CHECK(std::sqrt(moments.covariance()(0, 0)) == Approx(0.1).epsilon(0.1));
    CHECK(std::sqrt(moments.covariance()(1, 1)) == Approx(0.05).epsilon(0.1));
    CHECK(std::abs(correlation(0, 1)) < 0.1);
    CHECK(correlation(1) > 0.9);
    CHECK(correlation(16) == Approx(0.425).margin(0.275));
    CHECK(std::abs(correlation(200)) < 0.15);
}
