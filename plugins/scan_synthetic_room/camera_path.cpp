#include "camera_path.h"

#include "noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace room
{

namespace
{

using fresco::Vec3d;

constexpr float clearance = 0.22f;

/// OpenCV axes: z toward the target, y down, x right.
fresco::RigidTransform look_at(Vec3d eye, Vec3d target, double roll)
{
    const Vec3d forward = normalized(target - eye);
    const Vec3d level = normalized(cross(forward, Vec3d{0, 0, 1}));
    const Vec3d down = cross(forward, level);
    const Vec3d right = level * std::cos(roll) + down * std::sin(roll);
    const Vec3d below = down * std::cos(roll) - level * std::sin(roll);
    fresco::RigidTransform pose;
    pose.rotation.m = {right.x, below.x, forward.x, right.y, below.y, forward.y, right.z, below.z, forward.z};
    pose.translation = eye;
    return pose;
}

/// Toward the middle of the room, between table and lamp, until nothing is near.
Vec3d kept_clear(const Scene& scene, Vec3d eye)
{
    const Vec3d middle{scene.size.x / 2.0, scene.size.y / 2.0, 1.33};
    for (int step = 0; step < 80 && free_distance(scene, fresco::vec_cast<float>(eye)) < clearance; ++step)
        eye = eye + (middle - eye) * 0.05;
    return eye;
}

}  // namespace

Recorder make_recorder(int color_width, int color_height, int depth_width, int depth_height)
{
    const double color_focal = 1.06 * color_height, depth_focal = 1.18 * depth_height;
    Recorder recorder;
    recorder.color = {color_width, color_height, color_focal, color_focal, 0.502 * color_width, 0.496 * color_height};
    recorder.depth = {depth_width, depth_height, depth_focal, depth_focal, 0.5 * depth_width, 0.5 * depth_height};
    const double turn = 0.4 * std::numbers::pi / 180;
    recorder.color_from_depth.rotation.m = {std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
    recorder.color_from_depth.translation = {-0.025, 0.0, 0.002};
    return recorder;
}

std::vector<fresco::RigidTransform> camera_path(const Scene& scene, int count, std::uint32_t seed)
{
    const double l = static_cast<double>(scene.size.x), w = static_cast<double>(scene.size.y);
    const int across = (count + 1) / 2;
    std::vector<fresco::RigidTransform> poses;
    for (int i = 0; i < count; ++i)
    {
        const bool first_round = i < across;
        const int steps = first_round ? across : count - across, step = first_round ? i : i - across;
        const double turn = 2 * std::numbers::pi * (step + (first_round ? 0.0 : 0.5)) / steps;
        const auto jitter = [&](std::uint32_t what)
        { return static_cast<double>(bell(hash(seed, hash(static_cast<std::uint32_t>(i), what)))); };
        const double reach = first_round ? 0.36 : -0.12;
        const Vec3d eye{l * (0.5 + reach * std::cos(turn)) + 0.03 * jitter(1),
                        w * (0.5 + reach * std::sin(turn)) + 0.03 * jitter(2),
                        1.42 + (first_round ? 0.26 : 0.20) * std::sin(3 * turn) + 0.02 * jitter(3)};
        // Across: past the middle, at table height. Along the wall: down to the floor. Outward: at the walls, up and down.
        const bool along_wall = first_round && step % 4 == 3;
        const double sway = along_wall ? 1.1 : first_round ? 0.35 * std::sin(5 * turn) : 0.0;
        const double aim = along_wall ? 0.40 : first_round ? -0.20 : 0.50;
        const double height = along_wall    ? 0.1
                              : first_round ? 0.75 + 0.35 * std::sin(4 * turn + 1)
                                            : 1.10 + 1.6 * std::sin(7 * turn + 0.7);
        const Vec3d target{l * (0.5 + aim * std::cos(turn + sway)), w * (0.5 + aim * std::sin(turn + sway)), height};
        poses.push_back(look_at(kept_clear(scene, eye), target, 0.02 * jitter(4)));
    }
    return poses;
}

}  // namespace room
