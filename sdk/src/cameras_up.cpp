#include <fresco/cameras_up.h>

namespace fresco
{
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
    // Of a symmetric matrix: the mean of r rᵀ, less a little of m mᵀ, which decides where all cameras look the same way.
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
