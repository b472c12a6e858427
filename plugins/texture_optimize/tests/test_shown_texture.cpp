#include "shown_texture.h"

#include "catch.h"

using namespace fresco;
using namespace fresco::optimize;

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

TEST_CASE("a texture is shown through the map, black where nothing is seen")
{
    const UvMap map = square(8, 16);
    const Raster8 picture = ShownTexture(pattern()).shown(map);
    REQUIRE(picture.width == 8);
    REQUIRE(picture.channels == 3);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
        {
            const bool seen = map.valid.at(x, y) != 0;
            CHECK(picture.at(x, y, 0) == Approx(seen ? 255 * static_cast<double>(map.uv.at(x, y, 0)) : 0).margin(1));
            CHECK(picture.at(x, y, 1) == Approx(seen ? 255 * static_cast<double>(map.uv.at(x, y, 1)) : 0).margin(1));
        }
}

TEST_CASE("detail finer than a view's pixels is averaged, and kept where pixels are finer")
{
    const ShownTexture texture(pattern());
    const auto blue = [&](int pixels, double side)
    {
        const Raster8 picture = texture.shown(square(pixels, side));
        std::pair<int, int> range{255, 0};
        for (int i = 1; i < pixels * pixels; ++i)
        {
            const int value = picture.values[static_cast<std::size_t>(3 * i + 2)];
            range = {std::min(range.first, value), std::max(range.second, value)};
        }
        return range;
    };
    const auto [dark, bright] = blue(64, 8);
    CHECK(dark < 40);
    CHECK(bright > 215);
    const auto [least, most] = blue(8, 32);
    CHECK(least > 125);
    CHECK(most < 131);
}

TEST_CASE("the border between two charts is no reason to look coarsely")
{
    // The right half is another chart, far away in the texture.
    UvMap map = square(16, 8);
    for (int y = 0; y < 16; ++y)
        for (int x = 8; x < 16; ++x)
            map.uv.at(x, y, 0) += 0.5F;
    const Raster8 picture = ShownTexture(pattern()).shown(map);
    int least = 255;
    int most = 0;
    for (int y = 1; y < 16; ++y)
        for (const int x : {7, 8})
        {
            least = std::min<int>(least, picture.at(x, y, 2));
            most = std::max<int>(most, picture.at(x, y, 2));
        }
    CHECK(least < 110);
    CHECK(most > 145);
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
