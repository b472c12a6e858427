#include "catch.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/texturing/texture_pictures.h>

#include <limits>

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
    testing::TestRun run;
    const RasterF rgb = collapse(texture, run);
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

TEST_CASE("a texel of a coarse layer is centerd on its four fine texels")
{
    Texture texture;
    texture.layers = {RasterF(4, 4, 3, 0.0F), RasterF(2, 2, 3, 0.0F)};
    texture.layers[1].at(0, 0, 0) = 1;
    texture.seen = Raster8(4, 4);
    testing::TestRun run;
    const RasterF rgb = collapse(texture, run);
    CHECK(rgb.at(0, 0) == 1);                    // clamped at the border
    CHECK(rgb.at(1, 1) == Approx(0.75 * 0.75));  // a quarter of a coarse texel from its center
    CHECK(rgb.at(2, 1) == Approx(0.25 * 0.75));
    CHECK(rgb.at(3, 3) == 0);
}

TEST_CASE("the network's values become displayed RGB")
{
    Texture texture;
    texture.values = "network";
    texture.layers = {RasterF(1, 1, 3, 0.0F)};
    texture.layers[0].values = {255 - 103.939F, 51 - 116.779F, -200};  // B, G, R
    texture.seen = Raster8(1, 1);
    testing::TestRun run;
    const RasterF rgb = collapse(texture, run);
    CHECK(rgb.at(0, 0, 0) == 0);  // clamped
    CHECK(rgb.at(0, 0, 1) == Approx(0.2));
    CHECK(rgb.at(0, 0, 2) == Approx(1));
}

TEST_CASE("a texture that breaks its contract is refused")
{
    testing::TestRun run;
    Texture texture = pyramid(8, 1);
    CHECK_NOTHROW(check_texture(texture));
    texture.values = "lab";
    CHECK_THROWS_WITH(check_texture(texture), Catch::Contains("\"lab\""));
    texture = pyramid(8, 1);
    texture.layers[1] = RasterF(5, 5, 3);
    CHECK_THROWS_WITH(check_texture(texture), Catch::Contains("layer 1 is 5x5x3"));
    texture = pyramid(8, 1);
    texture.seen = Raster8(4, 4);
    CHECK_THROWS_WITH(check_texture(texture), Catch::Contains("seen mask is 4x4"));
    texture.layers.clear();
    CHECK_THROWS_WITH(check_texture(texture), Catch::Contains("no layers"));
    texture = pyramid(8, 1);
    texture.layers[0].at(3, 2, 1) = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(collapse(texture, run), Catch::Contains("texel (3, 2)"));
}
