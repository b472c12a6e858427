#include "catch.h"
#include "source_use.h"

#include <fresco/error.h>

#include <functional>
#include <optional>

using namespace fresco;

namespace
{
/// A map of `size` x `size` texels into a picture of 64 x 64.
SourceMap map_of(int size, const std::function<std::optional<Vec2f>(int, int)>& place, int width = 64, int height = 64)
{
    SourceMap map;
    map.picture_width = width;
    map.picture_height = height;
    map.places = Raster16(size, size, 3, SourceMap::none);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            if (const auto at = place(x, y))
                map.set_place(x, y, {*at, 0});
    return map;
}

Vec2f center(int x, int y)
{
    return {static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F};
}
}  // namespace

TEST_CASE("a copy of the picture uses all of it, evenly")
{
    const SourceUse use = source_use(map_of(64, center));
    CHECK(use.texels == 4096);
    CHECK(use.picture_used == 1);
    // A window of 6.4 px holds the centers of 7 x 7 pixels at most.
    CHECK(use.largest_share == Approx(49.0 / 4096));
    // As large texels: two pixels a side, a quarter of the cells.
    SourceMap coarse = map_of(32,
                              [](int x, int y) {
                                  return Vec2f{2.0F * static_cast<float>(x) + 1, 2.0F * static_cast<float>(y) + 1};
                              });
    CHECK(source_use(coarse).picture_used == Approx(0.25));
    coarse.pixels_per_texel = 2;
    CHECK(source_use(coarse).picture_used == 1);
}

TEST_CASE("one spot of the picture repeated is a small part used and a large share")
{
    const SourceUse spot = source_use(map_of(20, [](int, int) { return center(40, 9); }));
    CHECK(spot.picture_used == Approx(1.0 / 4096));
    CHECK(spot.largest_share == 1);
    // Two spots share a window of 6.4 px or they do not.
    for (const auto& [apart, share] : {std::pair{5, 1.0}, std::pair{8, 0.75}})
        CHECK(source_use(map_of(20, [apart = apart](int x, int) { return center(x % 4 == 0 ? 40 + apart : 40, 9); }))
                  .largest_share == Approx(share));
    // The left half, and nothing for every other texel.
    const SourceUse half =
        source_use(map_of(128, [](int x, int y) { return x % 2 == 0 ? std::optional(center(x / 4, y / 2)) : std::nullopt; }));
    CHECK(half.texels == 8192);
    CHECK(half.picture_used == Approx(0.5));
}

TEST_CASE("the picture's border and odd shapes")
{
    const auto corners = [](int x, int y) { return Vec2f{x == 0 ? 0.0F : 640.0F, y == 0 ? 0.0F : 10.0F}; };
    SourceMap strip = map_of(2, corners, 640, 10);
    strip.pixels_per_texel = 4;
    const SourceUse use = source_use(strip);
    CHECK(use.picture_used == Approx(4.0 / (160 * 3)));
    // The window of 8 px does not reach from top to bottom.
    CHECK(use.largest_share == Approx(0.25));
    CHECK_THROWS_WITH(source_use(map_of(4, [](int, int) { return std::nullopt; })),
                      Catch::Contains("has no texel from the picture"));
}
