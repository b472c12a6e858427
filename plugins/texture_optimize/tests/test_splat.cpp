#include "splat.h"

#include "catch.h"

using namespace fresco;
using namespace fresco::optimize;

namespace
{

UvMap one_pixel(float u, float v, float depth, float cosine)
{
    UvMap map{RasterF(1, 1, 2), RasterF(1, 1), RasterF(1, 1), Raster8(1, 1, 1, 1)};
    map.uv.values = {u, v};
    map.depth.values = {depth};
    map.cosine.values = {cosine};
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
    CHECK(covered.at(1, 0) == 1);
    CHECK(covered.at(1, 3) == 0);
    CHECK(colors.at(0, 0, 2) == 0);
}

TEST_CASE("a pixel between four texels marks them all and gives each its share")
{
    TexelGatherer gatherer(4, true);
    gatherer.add(one_pixel(0.5F, 0.5F, 1, 1), one_color(0.75F));
    Raster8 covered;
    const auto colors = gatherer.take_colors(covered);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
        {
            const bool inside = (x == 1 || x == 2) && (y == 1 || y == 2);
            CHECK(static_cast<bool>(gatherer.seen().at(x, y)) == inside);
            CHECK(colors.at(x, y, 0) == Approx(inside ? 0.75 : 0.0));
        }
}
