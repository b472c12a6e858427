#include "catch.h"

#include <fresco/geometry/closest_triangle.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace fresco;
using namespace fresco::geometry;

TEST_CASE("the closest point lies in the face, on a side or in a corner")
{
    const Corners3 t{Vec3d{0, 0, 0}, Vec3d{2, 0, 0}, Vec3d{0, 2, 0}};
    CHECK(closest_point(t, {0.5, 0.5, 3}) == Vec3d{0.5, 0.5, 0});
    CHECK(closest_point(t, {1, -4, 1}) == Vec3d{1, 0, 0});
    CHECK(closest_point(t, {5, -1, 0}) == Vec3d{2, 0, 0});
    CHECK(closest_point(t, {2, 2, 0}) == Vec3d{1, 1, 0});
    const Corners3 segment{Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{4, 0, 0}};
    CHECK(closest_point(segment, {1, 3, 0}) == Vec3d{1, 0, 0});
}

TEST_CASE("the tree finds what a look at every triangle finds")
{
    fresco::Random random(1);
    const auto anywhere = [&] { return Vec3d{random.uniform(), random.uniform(), random.uniform()}; };
    std::vector<Corners3> triangles;
    for (int i = 0; i < 500; ++i)
    {
        const Vec3d at = anywhere();
        triangles.push_back({at, at + anywhere() * 0.1, at + anywhere() * 0.1});
    }
    const ClosestTriangle tree(triangles);
    for (int i = 0; i < 300; ++i)
    {
        const Vec3d point = anywhere() * 1.5;
        double least = std::numeric_limits<double>::infinity();
        for (const auto& t : triangles)
            least = std::min(least, length(closest_point(t, point) - point));
        const auto found = tree.find(point);
        CHECK(found.distance == least);
        CHECK(length(closest_point(triangles[found.triangle], point) - point) == least);
        CHECK(tree.find(point, least + 1e-9).triangle == found.triangle);
        CHECK(std::isinf(tree.find(point, 0.99 * least).distance));
    }
}
