#include "pictures.h"
#include "released_view.h"

#include "catch.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/testing_scenes.h>

#include <array>
#include <cmath>

using namespace fresco;
using namespace fresco::optimize;

TEST_CASE("style sizes by hand, as the paper and as the released code find them")
{
    struct Case
    {
        Protocol protocol;
        int width, height;
        std::array<int, 2> fine, coarse;
    };
    for (const Case& c :
         {Case{Protocol::paper, 1024, 512, {512, 256}, {1024, 512}},
          {Protocol::paper, 1200, 1600, {256, 341}, {1024, 1364}},
          {Protocol::paper, 5000, 2500, {512, 256}, {2048, 1024}},             // first 2048 x 1024
          {Protocol::paper, 300, 200, {300, 200}, {300, 200}},                 // with a message
          {Protocol::released_scannet, 1600, 1200, {341, 256}, {800, 600}},    // 256, 300, 600, 1200: the third is 600
          {Protocol::released_scannet, 1024, 2048, {256, 512}, {512, 1024}},   // 256, 256, 512, 1024
          {Protocol::released_scannet, 400, 300, {341, 256}, {400, 300}},      // 256, 300, 300
          {Protocol::released_scannet, 1023, 511, {512, 256}, {1023, 511}},    // 256, 511, 511
          {Protocol::released_scannet, 200, 100, {512, 256}, {200, 100}},      // 256, 100, 100
          {Protocol::released_scannet, 3000, 1500, {512, 256}, {1024, 512}}})  // shorter side 2048 first: 256, 256, 512, …
    {
        CAPTURE(c.width, c.height);
        std::vector<std::string> messages;
        const StyleSizes s =
            style_sizes(Raster8(c.width, c.height, 3, 100), c.protocol, [&](const std::string& m) { messages.push_back(m); });
        CHECK(std::array{s.fine.width, s.fine.height} == c.fine);
        CHECK(std::array{s.coarse.width, s.coarse.height} == c.coarse);
        CHECK(messages.size() == (c.width == 300 ? 1 : 0));
    }
}

namespace
{
Raster8 pattern(int width, int height)
{
    return testing::picture(width, height, [](int x, int y, int c) { return (x * 37 + y * 91 + c * 50 + x * y * 13) % 256; });
}
}  // namespace

TEST_CASE("pictures are resized as Pillow resizes them, enlarged or reduced")
{
    const auto reds = [](const Raster8& picture)
    {
        std::vector<int> values;
        for (std::size_t i = 0; i < picture.values.size(); i += 3)
            values.push_back(picture.values[i]);
        return values;
    };
    // By Pillow 9.4.
    CHECK(reds(bicubic(pattern(5, 4), 7, 5)) == std::vector<int>{0,   14,  43,  69,  94,  129, 155, 57,  80,  122, 168, 215,
                                                                 148, 47,  149, 190, 190, 122, 167, 151, 103, 138, 189, 180,
                                                                 75,  122, 153, 158, 6,   46,  111, 174, 249, 172, 50});
    CHECK(reds(bicubic(pattern(5, 4), 3, 2)) == std::vector<int>{80, 132, 131, 130, 152, 144});
    const Raster8 reduced = bicubic(pattern(200, 150), 64, 48);
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < reduced.values.size(); ++i)
        sum += static_cast<std::int64_t>(reduced.values[i] * (i % 1000));
    CHECK(sum == 578376927);
    CHECK(bicubic(reduced, 64, 48) == reduced);
}

TEST_CASE("a released view has the largest map's pixels, and depth that mixes with holes")
{
    const auto map = [](int width, int height)
    {
        return UvMap{RasterF(width, height, 2, 0.5F), RasterF(width, height, 1, 3), RasterF(width, height, 1, 1),
                     Raster8(width, height, 1, 1)};
    };
    std::vector<UvMap> maps{map(5, 4), map(15, 12)};
    maps[0].valid.at(0, 0) = 0;
    maps[1].valid.at(3 * 2 + 1, 3 * 2 + 1) = 0;
    Raster<double> sensor(3, 2);
    sensor.values = {0, 1, 1.29, 2, 0, 1.5};
    const ReleasedView matterport = released_view(maps, pattern(20, 15), sensor, Protocol::released_matterport3d);
    CHECK(matterport.picture == bicubic(pattern(20, 15), 5, 4));
    // By OpenCV's INTER_LINEAR; where nothing was measured, next to no distance.
    const std::vector<double> expected{1e-6, 0.4, 1, 1.174,  1.29,   0.5, 0.6, 0.75, 1.1055, 1.3425,
                                       1.5,  1,   0, 0.9685, 1.4475, 2,   1.2, 1e-6, 0.9,    1.5};
    for (std::size_t i = 0; i < expected.size(); ++i)
        CHECK(matterport.depth.values[i] == Approx(expected[i]).epsilon(1e-6));
    // The mesh's, where no depth was recorded.
    const ReleasedView drawn = released_view(maps, pattern(20, 15), {}, Protocol::released_scannet);
    CHECK((drawn.depth.at(0, 0) == 3 && drawn.depth.at(2, 2) == 0));
    CHECK(drawn.picture == bicubic(exported_for_stylemesh(pattern(20, 15)), 5, 4));
    // On ScanNet a pixel without a measurement takes part in nothing.
    sensor = Raster<double>(320, 240, 1, 2);
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 64; ++x)
            sensor.at(x, y) = 0;
    const ReleasedView scannet = released_view(maps, pattern(20, 15), sensor, Protocol::released_scannet);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x)
            CHECK(scannet.depth.at(x, y) == (x == 0 || (x == 2 && y == 2) ? 0 : 2));
}

TEST_CASE("the released code shrinks a style picture without antialiasing")
{
    // A fourth of the pixels along a side: means of the two in the middle, not of four.
    const Raster8 stripes = testing::picture(1024, 1024, [](int x, int, int) { return x % 4 == 1 ? 100 : x % 4 == 3 ? 255 : 0; });
    const StyleSizes s = style_sizes(stripes, Protocol::released_scannet, [](const std::string&) {});
    CHECK(s.fine.at(17, 5, 1) == Approx(50 / 255.0));
    CHECK(s.coarse.at(8, 5, 0) == Approx(50 / 255.0));
    CHECK(s.coarse.at(9, 5, 0) == Approx(127.5 / 255.0));
}

TEST_CASE("gray is spread, transparent and other pictures are refused")
{
    const auto ignore = [](const std::string&) {};
    Raster8 rgba = testing::picture(
        64, 64,
        [](int, int, int c) {
            return std::array{255, 0, 51, 250}[static_cast<std::size_t>(c)];
        },
        4);
    const auto opaque = style_sizes(rgba, Protocol::paper, ignore).fine;
    CHECK(opaque.values[0] == Approx(1));
    CHECK(opaque.values[1] == Approx(5 / 255.0));
    rgba.values[4 * 100 + 3] = 249;
    CHECK_THROWS_WITH(style_sizes(rgba, Protocol::paper, ignore),
                      Catch::Contains("transparent pixels") && Catch::Contains("texture.synthesize"));
    CHECK(style_sizes(Raster8(64, 64, 1, 51), Protocol::paper, ignore).fine.at(1, 1, 2) == Approx(0.2));
    CHECK_THROWS_AS(style_sizes(Raster8(64, 64, 2), Protocol::paper, ignore), Error);
    CHECK_THROWS_WITH(style_sizes(Raster8(100, 63, 3), Protocol::released_scannet, ignore),
                      Catch::Contains("100x63") && Catch::Contains("64 px"));
    CHECK_THROWS_AS(style_sizes(Raster8(), Protocol::paper, ignore), Error);
}

namespace
{

constexpr int size = 64;

/// Looks at a square of `side` texels around (0.25, 0.25) with pixels x pixels; the first pixel sees nothing.
UvMap square(int pixels, double side)
{
    UvMap map{RasterF(pixels, pixels, 2), RasterF(pixels, pixels), RasterF(pixels, pixels), Raster8(pixels, pixels, 1, 1)};
    for (int y = 0; y < pixels; ++y)
        for (int x = 0; x < pixels; ++x)
        {
            const auto at = [&](int i) { return static_cast<float>(0.25 + side / size * ((i + 0.5) / pixels - 0.5)); };
            map.uv.at(x, y, 0) = at(x);
            map.uv.at(x, y, 1) = at(pixels - 1 - y);
        }
    map.valid.at(0, 0) = 0;
    return map;
}

/// Red grows with u, green with v, blue alternates from texel to texel.
Texture pattern()
{
    Texture texture;
    RasterF& layer = texture.layers.emplace_back(size, size, 3);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            layer.at(x, y, 0) = (static_cast<float>(x) + 0.5F) / size;
            layer.at(x, y, 1) = 1 - (static_cast<float>(y) + 0.5F) / size;
            layer.at(x, y, 2) = (x + y) % 2 == 0 ? 1.0F : 0.0F;
        }
    return texture;
}

}  // namespace

TEST_CASE("a texture is shown through the map, black where nothing is seen; detail finer than its pixels is averaged")
{
    const ShownTexture texture(pattern());
    const UvMap map = square(8, 16);
    const Raster8 picture = texture.shown(map);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 2; ++c)
            {
                const double expected = map.valid.at(x, y) != 0 ? 255 * double{map.uv.at(x, y, c)} : 0;
                CHECK(picture.at(x, y, c) == Approx(expected).margin(1));
            }
    // The alternation of texels, in the columns from `first` to `last`.
    const auto blue = [&](const UvMap& seen, int first, int last)
    {
        const Raster8 shown = texture.shown(seen);
        std::vector<int> values;
        for (int y = 1; y < shown.height; ++y)
            for (int x = first; x <= last; ++x)
                values.push_back(shown.at(x, y, 2));
        return std::ranges::minmax(values);
    };
    const auto fine = blue(square(64, 8), 0, 63);
    CHECK((fine.min < 40 && fine.max > 215));
    const auto coarse = blue(square(8, 32), 0, 7);
    CHECK((coarse.min > 125 && coarse.max < 131));
    // The right half is another chart, far away in the texture: no reason to look coarsely at the border.
    UvMap charts = square(16, 8);
    for (int y = 0; y < 16; ++y)
        for (int x = 8; x < 16; ++x)
            charts.uv.at(x, y, 0) += 0.5F;
    const auto border = blue(charts, 7, 8);
    CHECK((border.min < 110 && border.max > 145));
}

TEST_CASE("layers are summed and clamped")
{
    Texture texture;
    texture.layers.emplace_back(32, 32, 3, 0.75F);
    texture.layers.emplace_back(16, 16, 3, 0.5F);
    texture.layers[1].at(0, 0, 1) = -2;
    const RasterF sum = displayed(texture);
    CHECK(sum.width == 32);
    CHECK(sum.at(20, 20, 0) == 1);
    CHECK(sum.at(0, 0, 1) == 0);
}

namespace
{

UvMap one_pixel(float u, float v, float depth, float cosine)
{
    UvMap map{RasterF(1, 1, 2), RasterF(1, 1, 1, depth), RasterF(1, 1, 1, cosine), Raster8(1, 1, 1, 1)};
    map.uv.values = {u, v};
    return map;
}

RasterF one_color(float r)
{
    RasterF color(1, 1, 3);
    color.values = {r, 0.5F, 1};
    return color;
}

}  // namespace

TEST_CASE("texels take the mean of what is seen, weighted by cosine over depth")
{
    TexelGatherer gatherer(4, true);
    // The center of the texel in row 0, column 1.
    gatherer.add(one_pixel(0.375F, 0.875F, 2, 1), one_color(1));
    gatherer.add(one_pixel(0.375F, 0.875F, 1, 0.25F), one_color(0.25F));
    gatherer.mark(one_pixel(0.5F, 0.125F, 1, 1));
    CHECK((gatherer.seen().values == std::vector<std::uint8_t>{0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0}));
    Raster8 covered;
    const auto colors = gatherer.take_colors(covered);
    CHECK(colors.at(1, 0, 0) == Approx((0.5 * 1 + 0.25 * 0.25) / 0.75));
    CHECK(colors.at(1, 0, 1) == 0.5F);
    CHECK((covered.at(1, 0) == 1 && covered.at(1, 3) == 0));
}
