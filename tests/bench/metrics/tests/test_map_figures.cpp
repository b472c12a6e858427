#include "catch.h"
#include "map_figures.h"

#include <stdexcept>

using namespace fresco;
using namespace bench;

namespace
{

UvMap wall(int width, int height)
{
    UvMap map{RasterF(width, height, 2, 0.25F), RasterF(width, height, 1, 2.0F), RasterF(width, height, 1, 0.5F),
              Raster8(width, height, 1, 1)};
    return map;
}

}  // namespace

TEST_CASE("equal maps differ in nothing")
{
    const auto figures = map_figures(wall(5, 4), wall(5, 4));
    CHECK(figures.pixels == 20);
    CHECK(figures.other_validity_share == 0);
    CHECK(figures.other_surface_share == 0);
    CHECK(figures.largest_uv == 0);
    CHECK(figures.largest_depth_m == 0);
}

TEST_CASE("each difference is counted for what it is")
{
    const auto a = wall(5, 4);
    auto b = a;
    b.valid.values[0] = 0;
    b.uv.values[0] = 9;     // belongs to the invalid pixel
    b.depth.values[1] = 3;  // another surface
    b.uv.values[2] = 9;     // of that pixel: not compared
    b.depth.values[2] = 2.001F;
    b.uv.values[2 * 3 + 1] = 0.5F;
    b.cosine.values[4] = 0.25F;
    for (const auto& figures : {map_figures(a, b), map_figures(b, a)})
    {
        CHECK(figures.other_validity_share == Approx(0.05));
        CHECK(figures.other_surface_share == Approx(0.05));
        CHECK(figures.largest_depth_m == Approx(0.001).epsilon(1e-3));
        CHECK(figures.largest_uv == 0.25);
        CHECK(figures.largest_cosine == 0.25);
    }
    CHECK_THROWS_AS(map_figures(a, wall(4, 5)), std::invalid_argument);
}
