#include <fresco/camera.h>
#include <fresco/math.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace fresco
{

Vec3d operator*(const Mat3& a, Vec3d b)
{
    return {a(0, 0) * b.x + a(0, 1) * b.y + a(0, 2) * b.z, a(1, 0) * b.x + a(1, 1) * b.y + a(1, 2) * b.z,
            a(2, 0) * b.x + a(2, 1) * b.y + a(2, 2) * b.z};
}

Mat3 operator*(const Mat3& a, const Mat3& b)
{
    Mat3 product;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            product(row, column) = a(row, 0) * b(0, column) + a(row, 1) * b(1, column) + a(row, 2) * b(2, column);
    return product;
}

Mat3 transposed(const Mat3& a)
{
    return {{a(0, 0), a(1, 0), a(2, 0), a(0, 1), a(1, 1), a(2, 1), a(0, 2), a(1, 2), a(2, 2)}};
}

double determinant(const Mat3& a)
{
    return a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) - a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
           a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0));
}

RigidTransform RigidTransform::inverse() const
{
    const Mat3 inverse_rotation = transposed(rotation);
    return {inverse_rotation, -(inverse_rotation * translation)};
}

double RigidTransform::rotation_error() const
{
    const Mat3 gram = transposed(rotation) * rotation;
    const Mat3 identity;
    double largest = 0;
    bool is_finite = std::isfinite(translation.x) && std::isfinite(translation.y) && std::isfinite(translation.z);
    for (std::size_t i = 0; i < 9; ++i)
    {
        largest = std::max(largest, std::abs(gram.m[i] - identity.m[i]));
        is_finite = is_finite && std::isfinite(gram.m[i]);
    }
    return is_finite && determinant(rotation) >= 0 ? largest : std::numeric_limits<double>::infinity();
}

RigidTransform operator*(const RigidTransform& a, const RigidTransform& b)
{
    return {a.rotation * b.rotation, a.point(b.translation)};
}

Intrinsics Intrinsics::scaled_to(int new_width, int new_height) const
{
    const double sx = static_cast<double>(new_width) / width;
    const double sy = static_cast<double>(new_height) / height;
    return {new_width, new_height, fx * sx, fy * sy, cx * sx, cy * sy};
}

int Intrinsics::width_at(int new_height) const
{
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(new_height) * width / height)));
}

Vec3d Camera::project(Vec3d world_point) const
{
    const Vec3d p = transposed(world_from_camera.rotation) * (world_point - world_from_camera.translation);
    return {intrinsics.fx * p.x / p.z + intrinsics.cx, intrinsics.fy * p.y / p.z + intrinsics.cy, p.z};
}

Vec3d Camera::ray(double x, double y) const
{
    return world_from_camera.direction({(x - intrinsics.cx) / intrinsics.fx, (y - intrinsics.cy) / intrinsics.fy, 1.0});
}
namespace
{

Vec3d mean_direction(std::span<const RigidTransform> poses, Vec3d axis)
{
    Vec3d mean;
    for (const RigidTransform& pose : poses)
        mean += pose.direction(axis) * (1.0 / static_cast<double>(poses.size()));
    return mean;
}

}  // namespace

std::optional<Vec3d> cameras_up(std::span<const RigidTransform> poses)
{
    constexpr double least_agreement = 0.3;
    constexpr double clearly_better = 0.25;
    constexpr double share_of_mean = 0.05;
    constexpr int steps = 200;
    const Vec3d held_level = mean_direction(poses, {0, -1, 0});
    const Vec3d held_upright = mean_direction(poses, {-1, 0, 0});
    const bool is_upright = length(held_upright) > length(held_level) + clearly_better;
    const Vec3d mean = is_upright ? held_upright : held_level;
    if (!(length(mean) > least_agreement))
        return std::nullopt;
    // Rows of a symmetric matrix: the mean of r rᵀ, less a little of m mᵀ, which decides where all cameras look the same way.
    std::array<Vec3d, 3> rows{mean * (-share_of_mean * mean.x), mean * (-share_of_mean * mean.y),
                              mean * (-share_of_mean * mean.z)};
    for (const RigidTransform& pose : poses)
    {
        const Vec3d level = pose.direction(is_upright ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0});
        const Vec3d share = level * (1 / static_cast<double>(poses.size()));
        rows[0] += share * level.x;
        rows[1] += share * level.y;
        rows[2] += share * level.z;
    }
    // The eigenvector of the smallest eigenvalue, none of which is more than one.
    Vec3d up = normalized(mean);
    for (int step = 0; step < steps; ++step)
        up = normalized(up - Vec3d{dot(rows[0], up), dot(rows[1], up), dot(rows[2], up)});
    return dot(up, mean) < 0 ? up * -1.0 : up;
}

}  // namespace fresco
