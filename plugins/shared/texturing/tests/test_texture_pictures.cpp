#include "catch.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
/// Values in [0,1).
RasterF noise(int size, std::uint64_t seed)
{
    RasterF layer(size, size, 3);
    Random random(seed);
    for (float& v : layer.values)
        v = static_cast<float>(random.uniform());
    return layer;
}

Texture pyramid(int size, float scale)
{
    Texture texture;
    for (int i = 0; i < 3; ++i)
    {
        texture.layers.push_back(noise(size >> i, static_cast<std::uint64_t>(i) + 1));
        for (float& v : texture.layers.back().values)
            v *= scale;
    }
    texture.seen = Raster8(size, size, 1, 1);
    return texture;
}
}  // namespace

TEST_CASE("layers are summed as the lookup at each texel center sums them")
{
    const int size = 32;
    const Texture texture = pyramid(size, 0.33F);
    const RasterF rgb = collapse(texture, Progress());
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            float expected[3] = {0, 0, 0};
            for (const RasterF& layer : texture.layers)
            {
                float value[3];
                sample_bilinear(layer, (static_cast<float>(x) + 0.5F) / size, 1 - (static_cast<float>(y) + 0.5F) / size, value);
                for (int c = 0; c < 3; ++c)
                    expected[c] += value[c];
            }
            for (int c = 0; c < 3; ++c)
                CHECK(rgb.at(x, y, c) == Approx(expected[c]).margin(2e-6));
        }
}

TEST_CASE("the network's values become displayed RGB")
{
    Texture texture;
    texture.values = "network";
    texture.layers = {RasterF(1, 1, 3, 0.0F)};
    texture.layers[0].values = {255 - 103.939F, 51 - 116.779F, -200};  // B, G, R
    texture.seen = Raster8(1, 1);
    const RasterF rgb = collapse(texture, Progress());
    CHECK(rgb.at(0, 0, 0) == 0);  // clamped
    CHECK(rgb.at(0, 0, 1) == Approx(0.2));
    CHECK(rgb.at(0, 0, 2) == Approx(1));
}

TEST_CASE("a texture that breaks its contract, and an atlas without a source, are refused")
{
    const auto refused = [](const auto& change, const char* why)
    {
        Texture texture = pyramid(8, 1);
        change(texture);
        CHECK_THROWS_WITH((check_texture(texture), collapse(texture, Progress())), Catch::Contains(why));
    };
    refused([](Texture& texture) { texture.values = "lab"; }, "\"lab\"");
    refused([](Texture& texture) { texture.layers[1] = RasterF(5, 5, 3); }, "layer 1 is 5x5x3");
    refused([](Texture& texture) { texture.seen = Raster8(4, 4); }, "seen mask is 4x4");
    refused([](Texture& texture) { texture.layers.clear(); }, "no layers");
    refused([](Texture& texture) { texture.layers[0].at(3, 2, 1) = NAN; }, "texel (3, 2)");
    Raster8 image(4, 4, 3);
    CHECK_THROWS_WITH(fill_from_nearest(image, std::vector<std::uint8_t>(16, 0), Progress()), Catch::Contains("cover no texel"));
}

TEST_CASE("every gutter texel has the color of a nearest source")
{
    const int width = 61;
    const int height = 37;
    for (const int density : {2, 40, 400})
    {
        Raster8 image(width, height, 3);
        std::vector<std::uint8_t> source(static_cast<std::size_t>(width * height), 0);
        Random random(static_cast<std::uint64_t>(density));
        for (auto& is_source : source)
            is_source = random.below(2000) < density ? 1 : 0;
        source[700] = 1;
        // A source's color is its place.
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if (source[static_cast<std::size_t>(y * width + x)])
                {
                    image.at(x, y, 0) = static_cast<std::uint8_t>(x);
                    image.at(x, y, 1) = static_cast<std::uint8_t>(y);
                    image.at(x, y, 2) = 255;
                }
        fill_from_nearest(image, source, testing::TestRun());
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
            {
                int nearest = width * width + height * height;
                for (int sy = 0; sy < height; ++sy)
                    for (int sx = 0; sx < width; ++sx)
                        if (source[static_cast<std::size_t>(sy * width + sx)])
                            nearest = std::min(nearest, (sx - x) * (sx - x) + (sy - y) * (sy - y));
                const int dx = image.at(x, y, 0) - x;
                const int dy = image.at(x, y, 1) - y;
                REQUIRE(image.at(x, y, 2) == 255);
                REQUIRE(dx * dx + dy * dy == nearest);
            }
    }
}

namespace
{

/// Adds a rectangle of two faces with these texels (x to the right, y down) of a picture of `size`, as a chart of its own.
void add_chart(Mesh& mesh, int size, int left, int top, int right, int bottom)
{
    const auto at = [&](int texel) { return static_cast<float>(texel) / static_cast<float>(size); };
    const auto z = static_cast<float>(mesh.positions.size());
    Mesh chart = testing::rectangle({at(left), 1 - at(bottom), z}, {at(right - left), 0, 0}, {0, at(bottom - top), 0});
    testing::set_texcoords(chart, [](Vec3f p) { return Vec2f{p.x, p.y}; });
    testing::append(mesh, chart);
}

}  // namespace

TEST_CASE("sRGB's curve: known values, and every step comes back")
{
    CHECK(to_linear(188) == Approx(0.5028865).epsilon(1e-6));
    CHECK(to_linear(10) == Approx(10 / 255.0 / 12.92));
    for (int step = 0; step < 256; ++step)
        CHECK(from_linear(to_linear(static_cast<std::uint8_t>(step))) == step);
    CHECK(from_linear(-1) == 0);
    CHECK(from_linear(2) == 255);
    int last = 0;
    for (int i = 0; i <= 100'000; ++i)
    {
        const double light = i / 100'000.0;
        const int step = from_linear(light);
        REQUIRE(step >= last);
        REQUIRE(std::abs(255 * displayed(light) - step) < 0.5 + 1e-3);
        last = step;
    }
}

TEST_CASE("a smaller picture averages light, not steps")
{
    TexturedMesh textured;
    add_chart(textured.mesh, 8, 0, 0, 8, 8);
    textured.image = Image(testing::checkerboard(8, 8, 1));
    const testing::TestRun run;
    // Half the light is step 188; half the steps would be 128.
    CHECK(smaller_picture(textured, 4, run) == Raster8(4, 4, 3, 188));
    // Thirds of texels: the middle one of three averages 8/3 texels a side, half of them white within a texel's share.
    for (const std::uint8_t value : smaller_picture(textured, 3, run).values)
        CHECK(std::abs(value - 188) <= 12);
    for (const int size : {8, 0})
        CHECK(smaller_picture(textured, size, run) == textured.image.pixels);
}

TEST_CASE("no color crosses the gutter of a smaller picture, whatever the factor")
{
    // Two charts of one color each that fill the halves of a picture, but for a gutter of one texel on both sides of the middle,
    // filled as texture.bake does it.
    TexturedMesh halves;
    add_chart(halves.mesh, 32, 0, 0, 15, 32);
    add_chart(halves.mesh, 32, 17, 0, 32, 32);
    halves.image = Image(testing::picture(32, 32, [](int x, int, int) { return x < 16 ? 20 : 220; }));
    for (const int size : {16, 11, 7, 4, 2})
    {
        const Raster8 small = smaller_picture(halves, size, testing::TestRun());
        CHECK(small.width == size);
        CHECK(std::ranges::all_of(small.values, [](std::uint8_t v) { return v == 20 || v == 220; }));
        CHECK(small.at(0, 0) == 20);
        CHECK(small.at(size - 1, size - 1) == 220);
    }
}
