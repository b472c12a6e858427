#include "catch.h"
#include "quadratic.h"

#include <cmath>

using fresco::Vec3d;

TEST_CASE("a face's error is the squared distance to its plane, times (twice its area)^1.25")
{
    const Quadratic unit = plane_error({1, 1, 3}, {2, 1, 3}, {1, 2, 3});
    CHECK(unit({-4, 9, 3}) == Approx(0).margin(1e-12));
    CHECK(unit({7, 7, 3.5}) == Approx(0.25));
    CHECK(unit({7, 7, 2.5}) == Approx(0.25));
    const Quadratic four = plane_error({1, 1, 3}, {3, 1, 3}, {1, 3, 3});
    CHECK(four({0, 0, 5}) == Approx(4 * std::pow(4, 1.25)));
    const Quadratic none = plane_error({1, 1, 3}, {2, 1, 3}, {3, 1, 3});
    CHECK(none({5, 5, 5}) == 0);
    CHECK(none.trace() == 0);
}

TEST_CASE("a border edge's error is the squared distance to its line, times its squared length")
{
    const Quadratic line = line_error({1, 5, 5}, {3, 5, 5});
    CHECK(line({-10, 5, 5}) == Approx(0).margin(1e-9));
    CHECK(line({-10, 8, 9}) == Approx(25 * 4));
}

TEST_CASE("an edge becomes the corner where the planes around it meet")
{
    Quadratic planes;
    for (const Quadratic& face : {plane_error({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), plane_error({0, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                                  plane_error({0, 0, 0}, {0, 0, 1}, {1, 0, 0})})
        planes.add(face);
    const Placement corner = place(planes, nullptr, {-0.1, 0.1, 0}, {0.1, 0.1, 0.3});
    CHECK(length(corner.point) < 1e-5);
    CHECK(corner.cost < 1e-8);
    CHECK(corner.cost >= 0);
}

TEST_CASE("on a flat surface an edge becomes its middle, and the shorter edge comes first")
{
    const Quadratic flat = plane_error({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    const Placement near = place(flat, nullptr, {0.2, 0.2, 1}, {0.4, 0.2, 1});
    CHECK(length(near.point - Vec3d{0.3, 0.2, 1}) < 1e-6);
    const Placement wide = place(flat, nullptr, {0, 0.2, 1}, {0.4, 0.2, 1});
    CHECK(near.cost < wide.cost);
    CHECK(near.cost > 0);
}

TEST_CASE("border edges hold the point on their line")
{
    const Quadratic flat = plane_error({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const Quadratic line = line_error({0, 0, 0}, {1, 0, 0});
    const Placement on = place(flat, &line, {0.5, 0, 0}, {0.6, 0.2, 0});
    CHECK(std::abs(on.point.y) < 1e-5);
    CHECK(std::abs(on.point.z) < 1e-9);
}

TEST_CASE("where no point near the edge serves the cost is infinite")
{
    CHECK(std::isinf(place({}, nullptr, {0, 0, 0}, {1, 0, 0}).cost));
    // Two planes that meet a hundred lengths away.
    Quadratic planes;
    planes.add(plane_error({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    planes.add(plane_error({0, 0, 0.1}, {1, 0, 0.101}, {0, 1, 0.1}));
    planes.add(plane_error({0, 0, 0}, {1, 0, 0}, {0, 0, 1}));
    CHECK(std::isinf(place(planes, nullptr, {0, 0, 0.05}, {0.1, 0, 0.05}).cost));
}
