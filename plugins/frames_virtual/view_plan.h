#pragma once

#include "coverage.h"

namespace fresco::virtual_views
{

/// Which way pictures have up: as the recorded ones, so that strokes run alike in all views.
struct Upright
{
    Vec3d up;               ///< World, unit length.
    int quarter_turns = 0;  ///< Clockwise turns of the picture that bring up to its top.
};
Upright upright_of(const Frames& frames, Vec3d up);

/// A camera at `eye` that looks along `forward` (unit length) without roll.
Camera level_camera(const Intrinsics& intrinsics, Vec3d eye, Vec3d forward, const Upright& upright);

struct PlanRules
{
    Intrinsics intrinsics;
    Upright upright;
    double distance_m;       ///< The best distance.
    double angle_weight;     ///< Value of seeing a point straight on, added to 1 for seeing it at all.
    double distance_weight;  ///< Value of seeing it from the best distance.
    std::size_t most_unpainted;
    std::size_t most_views;
};

struct ViewPlan
{
    std::vector<Camera> cameras;
    std::vector<std::uint32_t> unpainted;  ///< What is left of the points wanted.
};

/// Cameras at some of the places that together paint the points `wanted`, up to most_unpainted; each of them is seen by the
/// place that is its witness. A greedy choice, each time the camera that adds most to the sum of every point's best worth, in
/// rounds: the candidates look in all directions, at some of the points, and those that paint most of these are kept; then all
/// points are looked at, and what is left over is the next round's. A witness of some point looked at is always among the
/// places, and a round that paints nothing aims a camera at a point, so each ends with fewer points. Adds the cameras to
/// `coverage`. `witness`: of each wanted point, the number of its place. Throws Canceled.
ViewPlan plan_views(Coverage& coverage, std::span<const Vec3d> places, std::vector<std::uint32_t> wanted,
                    const std::vector<std::uint32_t>& witness, const PlanRules& rules, Progress& progress);

}  // namespace fresco::virtual_views
