#include "catch.h"

#include <fresco/images/filters.h>

#include <vector>

using namespace fresco;

TEST_CASE("push_pull keeps what is covered and fills the rest between its extremes, near ones first")
{
    RasterF picture(13, 9, 1);
    Raster8 covered(13, 9);
    picture.at(0, 0) = 1;
    covered.at(0, 0) = 1;
    picture.at(12, 8) = 3;
    covered.at(12, 8) = 1;
    push_pull(picture, covered);
    CHECK(picture.at(0, 0) == 1);
    CHECK(picture.at(12, 8) == 3);
    CHECK(picture.at(1, 1) < 1.5F);
    CHECK(picture.at(11, 8) > 2.5F);
    for (const float v : picture.values)
    {
        CHECK(v >= 1);
        CHECK(v <= 3);
    }
    RasterF one(8, 8, 2);
    Raster8 corner(8, 8);
    one.at(3, 3, 0) = 0.5F;
    one.at(3, 3, 1) = 0.25F;
    corner.at(3, 3) = 1;
    push_pull(one, corner);
    for (int i = 0; i < 64; ++i)
    {
        CHECK(one.at(i % 8, i / 8, 0) == Approx(0.5));
        CHECK(one.at(i % 8, i / 8, 1) == Approx(0.25));
    }
    RasterF nothing(4, 4, 1, 7);
    push_pull(nothing, Raster8(4, 4));
    CHECK(nothing.values == std::vector<float>(16, 7.0F));
}
