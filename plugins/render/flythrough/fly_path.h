#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <span>
#include <vector>

/// \file The camera's path through the room, for the stage.

/// Poses (world_from_camera, OpenCV axes) along the smoothed recording: positions and directions are Gaussian means, sigma
/// `smoothing_count` poses. Returns `count` poses (at least 1) from the first end of the smooth path to the last at a steady
/// speed: meters along the path, where a radian of rotation counts as one. `recorded` must not be empty.
std::vector<fresco::RigidTransform> recorded_path(std::span<const fresco::RigidTransform> recorded, double smoothing_count,
                                                  std::size_t count);

/// The directions of an orbit, radians to the right of ahead: from `first` to `last` and back, or once around.
struct OrbitArc
{
    double first = 0;
    double last = 0;
    bool around = true;
};

/// The widest range of directions in which at least half of the picture shows the room. `shares`: share of the picture, 0 to 1,
/// in evenly spaced directions from ahead to the right. Once around if the condition holds in all directions or in none.
OrbitArc orbit_arc(std::span<const double> shares);

/// `count` poses on a level circle of `radius_m` around the mean position of `recorded` (not empty), looking away from its middle
/// and down by `down_deg`. Ahead is the level direction closest to that of the first recorded pose. Around: from ahead to the
/// right, at a steady speed; along an arc: there and back, slow at its ends. The last pose is one step before the first, so that
/// a loop does not jump.
std::vector<fresco::RigidTransform> orbit_path(std::span<const fresco::RigidTransform> recorded, double radius_m, double down_deg,
                                               std::size_t count, const OrbitArc& arc = {});
