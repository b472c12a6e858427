#include "fly_path.h"

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{

/// A camera by its place and two of its axes, which can be averaged.
struct Look
{
    Vec3d place;
    Vec3d forward;
    Vec3d down;
};

Look look_of(const RigidTransform& pose)
{
    return {pose.translation, pose.direction({0, 0, 1}), pose.direction({0, 1, 0})};
}

/// With axes at right angles; those of `fallback` where the averaged ones cancel.
RigidTransform pose_of(const Look& look, const Look& fallback)
{
    constexpr double least = 1e-6;
    const Vec3d forward = length(look.forward) > least ? normalized(look.forward) : fallback.forward;
    Vec3d right = cross(look.down, forward);
    if (length(right) <= least)
        right = cross(fallback.down, fallback.forward);
    right = normalized(right);
    const Vec3d down = cross(forward, right);
    RigidTransform pose;
    pose.rotation.m = {right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z};
    pose.translation = look.place;
    return pose;
}

Look blended(const Look& a, const Look& b, double share)
{
    return {a.place * (1 - share) + b.place * share, a.forward * (1 - share) + b.forward * share,
            a.down * (1 - share) + b.down * share};
}

std::vector<Look> smoothed(std::span<const RigidTransform> recorded, double sigma)
{
    constexpr double reach_sigmas = 3;
    const auto size = static_cast<std::ptrdiff_t>(recorded.size());
    const auto widest = static_cast<std::ptrdiff_t>(std::ceil(reach_sigmas * sigma));
    std::vector<Look> result;
    for (std::ptrdiff_t i = 0; i < size; ++i)
    {
        // Alike on both sides: the way begins and ends where the recording does.
        const std::ptrdiff_t reach = std::min({widest, i, size - 1 - i});
        Look sum{};
        double weights = 0;
        for (std::ptrdiff_t k = -reach; k <= reach; ++k)
        {
            const Look look = look_of(recorded[static_cast<std::size_t>(i + k)]);
            const double weight = k == 0 ? 1 : std::exp(-0.5 * static_cast<double>(k * k) / (sigma * sigma));
            sum.place += look.place * weight;
            sum.forward += look.forward * weight;
            sum.down += look.down * weight;
            weights += weight;
        }
        sum.place = sum.place * (1 / weights);
        result.push_back(look_of(pose_of(sum, look_of(recorded[static_cast<std::size_t>(i)]))));
    }
    return result;
}

double angle_between(Vec3d a, Vec3d b)
{
    return std::atan2(length(cross(a, b)), dot(a, b));
}

double way_between(const Look& a, const Look& b)
{
    return length(b.place - a.place) + std::max(angle_between(a.forward, b.forward), angle_between(a.down, b.down));
}

}  // namespace

std::vector<RigidTransform> recorded_path(std::span<const RigidTransform> recorded, double smoothing_count, std::size_t count)
{
    const std::vector<Look> looks = smoothed(recorded, smoothing_count);
    std::vector<double> ways{0};
    for (std::size_t i = 1; i < looks.size(); ++i)
        ways.push_back(ways.back() + way_between(looks[i - 1], looks[i]));
    std::vector<RigidTransform> path;
    std::size_t segment = 0;
    for (std::size_t i = 0; i < count; ++i)
    {
        const double way = count > 1 ? ways.back() * static_cast<double>(i) / static_cast<double>(count - 1) : 0;
        while (segment + 2 < looks.size() && ways[segment + 1] < way)
            ++segment;
        const std::size_t next = std::min(segment + 1, looks.size() - 1);
        const double span = ways[next] - ways[segment];
        const double share = span > 0 ? std::clamp((way - ways[segment]) / span, 0.0, 1.0) : 0;
        path.push_back(pose_of(blended(looks[segment], looks[next], share), looks[segment]));
    }
    return path;
}
