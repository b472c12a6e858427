#include "catch.h"
#include "clip.h"

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace raster;

namespace
{
const Intrinsics square{100, 100, 50, 50, 50, 50};  // the picture spans [-1, 1], its guard [-3, 3]

std::vector<std::pair<double, double>> places(const Clipped& part)
{
    std::vector<std::pair<double, double>> result;
    for (std::size_t i = 0; i < part.count; ++i)
        result.emplace_back(part.corners[i].x, part.corners[i].y);
    return result;
}
}  // namespace

TEST_CASE("a triangle between the planes stays as it is")
{
    const Clipped part = clipped({Vec3d{0, 0, 2}, {1, 0, 2}, {0, 1, 4}}, Frustum(square));
    REQUIRE(part.count == 3);
    CHECK(places(part) == std::vector<std::pair<double, double>>{{0, 0}, {0.5, 0}, {0, 0.25}});
    CHECK(part.corners[2].nearness == 0.25F);
}

TEST_CASE("surface behind the camera is cut off, and nothing is left of a mesh behind it")
{
    const Frustum frustum(square);
    CHECK(clipped({Vec3d{0, 0, -1}, {1, 0, -2}, {0, 1, -1}}, frustum).count == 0);
    // A floor one meter below that goes on behind the camera: it ends at the guard, y / z = 3.
    const Clipped part = clipped({Vec3d{-1, 1, -5}, {1, 1, -5}, {0, 1, 5}}, frustum);
    REQUIRE(part.count >= 3);
    double lowest = 0;
    for (const auto& [x, y] : places(part))
    {
        CHECK(std::abs(x) <= 3 + 1e-12);
        CHECK(y <= 3 + 1e-12);
        lowest = std::max(lowest, y);
    }
    CHECK(lowest == Approx(3));
}

TEST_CASE("a triangle wider than the guard is cut at it")
{
    const Clipped part = clipped({Vec3d{-10, -0.5, 1}, {10, -0.5, 1}, {0, 10, 1}}, Frustum(square));
    REQUIRE(part.count == 4);
    for (const auto& [x, y] : places(part))
        CHECK(std::max(std::abs(x), std::abs(y)) <= 3 + 1e-12);
}

TEST_CASE("two triangles get equal corners on their shared edge")
{
    const Frustum frustum(square);
    const Vec3d a{-0.3, 0.7, -1.1};
    const Vec3d b{0.9, 0.2, 1.7};
    const auto one = places(clipped({a, b, {2, 3, 1}}, frustum));
    const auto other = places(clipped({b, a, {-2, 1, 4}}, frustum));
    int shared = 0;
    for (const auto& place : one)
        shared += static_cast<int>(std::count(other.begin(), other.end(), place));
    CHECK(shared == 2);
}

TEST_CASE("sides tell what is out of sight and what must be cut")
{
    const Frustum frustum(square);
    const auto sides = [&](double x, double y, double z) { return frustum.project({x, y, z}).sides; };
    CHECK(sides(0, 0, 1) == 0);
    CHECK(sides(-2, 0, 1) == Frustum::left);
    CHECK(sides(2, 2, 1) == (Frustum::right | Frustum::below));
    CHECK(sides(0, -4, 1) == (Frustum::above | Frustum::far_aside));
    CHECK((sides(0.1, 0.1, -1) & Frustum::behind) != 0);
    CHECK(out_of_sight(sides(-2, 0, 1), sides(-4, 1, 1), sides(-2, -9, 1)));
    CHECK_FALSE(out_of_sight(sides(-2, 0, 1), sides(2, 0, 1), sides(0, 2, 1)));
    CHECK_FALSE(out_of_sight(sides(-4, 0, 1), sides(4, 0, 1), sides(0, 4, 1)));
    CHECK(needs_clipping(sides(0, 0, 1), sides(0, 0, 1), sides(0, 0, -1)));
    CHECK_FALSE(needs_clipping(sides(0, 0, 1), sides(2, 0, 1), sides(0, -2, 1)));
}
