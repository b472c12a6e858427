#include "catch.h"

#include <fresco/images/filters.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

using namespace fresco;

TEST_CASE("a blur keeps the sum, has its sigma and leaves what is flat or repeats at the border")
{
    RasterF point(61, 61);
    point.at(30, 30) = 1;
    const RasterF spread = blurred(point, 3);
    CHECK(std::accumulate(spread.values.begin(), spread.values.end(), 0.0) == Approx(1).epsilon(1e-5));
    double variance = 0;
    for (int x = 0; x < 61; ++x)
        for (int y = 0; y < 61; ++y)
            variance += double{spread.at(x, y)} * (x - 30) * (x - 30);
    CHECK(variance == Approx(9).epsilon(0.01));
    CHECK(spread.at(30, 30 - 12) > 0);
    CHECK(spread.at(30, 30 - 13) == 0);

    for (const float v : blurred(RasterF(5, 3, 3, 0.25F), 4).values)
        CHECK(v == Approx(0.25));
    // The first pixel is not repeated: 1 beside 0 is 0 1 0 beyond the border.
    RasterF edge(2, 1);
    edge.at(0, 0) = 1;
    const double near = std::exp(-0.5);
    const double far = std::exp(-2.0);
    const double farther = std::exp(-4.5);
    const double farthest = std::exp(-8.0);
    CHECK(blurred(edge, 1).at(0, 0) ==
          Approx((1 + 2 * far + 2 * farthest) / (1 + 2 * (near + far + farther + farthest))).epsilon(1e-6));
}

TEST_CASE("the variance around a pixel is that of its window, over all channels")
{
    Random random(5);
    RasterF picture(15, 12, 3);
    for (float& v : picture.values)
        v = static_cast<float>(50 * random.uniform());
    const RasterF variance = local_variance(picture, 1.5);
    REQUIRE(variance.channels == 1);
    RasterF point(15, 12);
    point.at(7, 5) = 1;
    const RasterF window = blurred(point, 1.5);  // Symmetric, so that it also says what counts at that pixel.
    double expected = 0;
    for (int c = 0; c < 3; ++c)
    {
        double mean = 0;
        double square = 0;
        for (int y = 0; y < 12; ++y)
            for (int x = 0; x < 15; ++x)
            {
                mean += double{window.at(x, y)} * double{picture.at(x, y, c)};
                square += double{window.at(x, y)} * std::pow(double{picture.at(x, y, c)}, 2);
            }
        expected += square - mean * mean;
    }
    CHECK(double{variance.at(7, 5)} == Approx(expected).epsilon(0.02));
    for (const float v : local_variance(RasterF(5, 3, 3, 80.3F), 4).values)
        CHECK(v < 0.01F);
}

TEST_CASE("the gradient of a slope is eight times its steps")
{
    RasterF slope(6, 5);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 6; ++x)
            slope.at(x, y) = static_cast<float>(2 * x - 3 * y);
    const Gradient g = sobel(slope);
    CHECK(g.x.at(3, 2) == 16);
    CHECK(g.y.at(3, 2) == -24);
    CHECK(g.x.at(0, 2) == 0);
    CHECK(g.y.at(3, 4) == 0);
    CHECK(g.y.at(0, 2) == -24);
}

TEST_CASE("push_pull keeps what is covered and fills the rest between its extremes, near ones first")
{
    RasterF picture(13, 9, 1);
    Raster8 covered(13, 9);
    picture.at(0, 0) = 1;
    covered.at(0, 0) = 1;
    picture.at(12, 8) = 3;
    covered.at(12, 8) = 1;
    push_pull(picture, covered);
    CHECK((picture.at(0, 0) == 1 && picture.at(1, 1) < 1.5F));
    CHECK((picture.at(12, 8) == 3 && picture.at(11, 8) > 2.5F));
    CHECK(std::ranges::all_of(picture.values, [](float v) { return v >= 1 && v <= 3; }));
    RasterF one(8, 8, 2);
    Raster8 corner(8, 8);
    one.at(3, 3, 0) = 0.5F;
    one.at(3, 3, 1) = 0.25F;
    corner.at(3, 3) = 1;
    push_pull(one, corner);
    for (std::size_t i = 0; i < one.values.size(); ++i)
        CHECK(one.values[i] == Approx(i % 2 == 0 ? 0.5 : 0.25));
    RasterF nothing(4, 4, 1, 7);
    push_pull(nothing, Raster8(4, 4));
    CHECK(nothing.values == std::vector<float>(16, 7.0F));
}
