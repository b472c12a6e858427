#include "catch.h"

#include <fresco/numerics/rotations.h>

#include <cmath>
#include <numbers>

using namespace fresco;

TEST_CASE("rotations turn by the right hand, given as a vector or as a quaternion")
{
    constexpr double quarter = std::numbers::pi / 2;
    CHECK(length(numerics::rotation_by({0, 0, quarter}) * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}) < 1e-15);
    CHECK(length(numerics::rotation_by({quarter, 0, 0}) * Vec3d{0, 1, 0} - Vec3d{0, 0, 1}) < 1e-15);
    CHECK(numerics::rotation_by({}) == Mat3{});
    CHECK(numerics::rotation_of(1, 0, 0, 0) == Mat3{});
    const Vec3d turn{0.3, -0.7, 1.1};
    const Vec3d v = normalized(turn) * std::sin(length(turn) / 2);
    const Mat3 expected = numerics::rotation_by(turn);
    const Mat3 found = numerics::rotation_of(std::cos(length(turn) / 2), v.x, v.y, v.z);
    for (std::size_t i = 0; i < 9; ++i)
        CHECK(found.m[i] == Approx(expected.m[i]).margin(1e-15));
    CHECK(RigidTransform{expected, {}}.rotation_error() < 1e-15);
}
