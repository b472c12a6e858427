#include "catch.h"

#include <fresco/recordings/lens.h>

#include <cmath>

using namespace fresco::recordings;

namespace
{

const fresco::Intrinsics camera{64, 48, 50, 52, 31, 25};

/// A picture whose value is a smooth function of the direction that a pinhole sees.
double scene(double x, double y)
{
    return 128 + 60 * std::sin(3 * x + 0.5) + 60 * std::cos(4 * y - 0.3);
}

/// The direction whose distorted one is `d`: the obvious fixed point, sure for mild lenses.
fresco::Vec2d undone(const Lens& lens, fresco::Vec2d d)
{
    fresco::Vec2d p = d;
    for (int i = 0; i < 200; ++i)
        p = p + (d - lens.distorted(p));
    return p;
}

}  // namespace

TEST_CASE("a lens displaces points as its coefficients say", "[recordings]")
{
    const fresco::Vec2d p{0.5, -0.25};
    const double r2 = 0.3125;
    CHECK(Lens{}.distorted(p) == p);
    CHECK_FALSE(Lens{}.distorts());
    const auto radial = Lens{.k1 = 0.1}.distorted(p);
    CHECK(radial.x == Approx(0.5 * (1 + 0.1 * r2)));
    CHECK(radial.y == Approx(-0.25 * (1 + 0.1 * r2)));
    CHECK(Lens{.k2 = 0.1}.distorted(p).x == Approx(0.5 * (1 + 0.1 * r2 * r2)));
    CHECK(Lens{.k4 = 0.1}.distorted(p).x == Approx(0.5 / (1 + 0.1 * r2)));
    const auto p1 = Lens{.p1 = 0.1}.distorted(p);
    CHECK(p1.x == Approx(0.5 + 2 * 0.1 * 0.5 * -0.25));
    CHECK(p1.y == Approx(-0.25 + 0.1 * (r2 + 2 * 0.0625)));
    const auto p2 = Lens{.p2 = 0.1}.distorted(p);
    CHECK(p2.x == Approx(0.5 + 0.1 * (r2 + 2 * 0.25)));
    CHECK(p2.y == Approx(-0.25 + 2 * 0.1 * 0.5 * -0.25));
}

TEST_CASE("a fisheye's radius is the angle to its axis", "[recordings]")
{
    // 45 degrees off the axis: a pinhole has the tangent, a fisheye the angle.
    const auto p = Lens{.is_fisheye = true}.distorted({0.6, 0.8});
    const double angle = std::atan(1.0);
    CHECK(p.x == Approx(0.6 * angle));
    CHECK(p.y == Approx(0.8 * angle));
    CHECK(Lens{.is_fisheye = true}.distorts());
    const auto bent = Lens{.k1 = 0.1, .k4 = 0.01, .is_fisheye = true}.distorted({1, 0});
    CHECK(bent.x == Approx(angle * (1 + 0.1 * std::pow(angle, 2) + 0.01 * std::pow(angle, 8))));
    CHECK(Lens{.k3 = 0.1, .is_fisheye = true}.distorted({1, 0}).x == Approx(angle * (1 + 0.1 * std::pow(angle, 6))));
}

TEST_CASE("a pinhole picture is what is left when the lens is undone", "[recordings]")
{
    for (const Lens& lens : {Lens{.k1 = -0.2, .k2 = 0.05}, Lens{.k1 = 0.2, .p1 = 0.004, .p2 = -0.006},
                             Lens{.k1 = 0.2624, .k2 = -0.9531, .k3 = 1.1633, .p1 = -0.0054, .p2 = 0.0026},
                             Lens{.k1 = 0.03, .k2 = 0.005, .k3 = 0.0006, .k4 = 0.0001, .is_fisheye = true}})
    {
        fresco::Raster8 picture(64, 48, 1);
        fresco::Raster16 depth(32, 24);
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x)
            {
                const auto p = undone(lens, {(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy});
                picture.at(x, y) = static_cast<std::uint8_t>(scene(p.x, p.y) + 0.5);
                depth.at(x / 2, y / 2) = 1000;
            }
        const auto pinhole = pinhole_without(lens, camera, "test");
        CHECK(pinhole.fx / camera.fx == Approx(pinhole.fy / camera.fy));
        CHECK((pinhole.cx == camera.cx && pinhole.cy == camera.cy && pinhole.width == 64));
        const auto straight = undistorted(picture, camera, lens, pinhole);
        double worst = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x)
            {
                const double expected = scene((x + 0.5 - pinhole.cx) / pinhole.fx, (y + 0.5 - pinhole.cy) / pinhole.fy);
                worst = std::max(worst, std::abs(straight.at(x, y) - expected));
            }
        CHECK(worst < 2.5);
        // No pixel is empty, and a slightly shorter focal length would leave some empty.
        const auto full = undistorted_depth(depth, camera, lens, pinhole);
        CHECK(full == fresco::Raster16(32, 24, 1, 1000));
        auto wider = pinhole;
        wider.fx *= 0.9;
        wider.fy *= 0.9;
        CHECK(undistorted_depth(depth, camera, lens, wider) != full);
    }
}

TEST_CASE("depth is that of the pixel that the lens shows there", "[recordings]")
{
    // The depth picture has half the camera's size. The pinhole's focal length is 4/3 of the camera's: the center of its column x
    // lies 3/4 (x + 0.5 - 4) + 4 pixels from the left.
    const fresco::Intrinsics whole{16, 12, 18, 18, 8, 6};
    fresco::Intrinsics pinhole = whole;
    pinhole.fx = pinhole.fy = 24;
    fresco::Raster16 depth(8, 6);
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        depth.values[i] = static_cast<std::uint16_t>(i);
    const auto straight = undistorted_depth(depth, whole, {}, pinhole);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x)
            CHECK(straight.at(x, y) == depth.at(static_cast<int>(0.75 * x + 1.375), static_cast<int>(0.75 * y + 1.125)));
}

TEST_CASE("a lens that folds the picture is refused", "[recordings]")
{
    for (const Lens& lens : {Lens{.k1 = -40}, Lens{.k1 = -40, .is_fisheye = true}, Lens{.p1 = 1e30}, Lens{.k4 = -1e9},
                             Lens{.k1 = 1e300, .k2 = 1e300}})
        CHECK_THROWS_WITH(pinhole_without(lens, camera, "cam.txt:3"), Contains("cam.txt:3: the lens' "));
}
