#include "recolor.h"

#include <ATen/ATen.h>

#include "catch.h"

#include <algorithm>

using fresco::Vec3d;

TEST_CASE("moments of two pixels by hand")
{
    auto picture = at::zeros({3, 1, 2}, at::kFloat);
    picture[0][0][1] = 1;
    const auto moments = patch_match::color_moments(picture);
    CHECK(moments.mean() == (Vec3d{0.5, 0, 0}));
    CHECK(moments.covariance()(0, 0) == 0.25);
}

TEST_CASE("recolored applies the map pixel by pixel and clamps")
{
    const auto picture = at::arange(60, at::kDouble).reshape({3, 4, 5}) / 60;
    const fresco::ColorMap map{fresco::Mat3{{2, 0, 0, 0, 1, 0.5, 0, 0.25, 1}}, {-0.5, 0.1, 0}};
    const auto result = patch_match::recolored(picture, map);
    REQUIRE(result.sizes() == picture.sizes());
    const auto in = picture.accessor<double, 3>();
    const auto out = result.accessor<double, 3>();
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x)
        {
            const auto expected = map(Vec3d{in[0][y][x], in[1][y][x], in[2][y][x]});
            CHECK(out[0][y][x] == Approx(std::clamp(expected.x, 0.0, 1.0)).margin(1e-12));
            CHECK(out[1][y][x] == Approx(std::clamp(expected.y, 0.0, 1.0)).margin(1e-12));
            CHECK(out[2][y][x] == Approx(std::clamp(expected.z, 0.0, 1.0)).margin(1e-12));
        }
}
