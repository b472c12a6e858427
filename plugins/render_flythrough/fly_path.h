#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <span>
#include <vector>

/// Poses (world_from_camera, OpenCV axes) along a recorded way, made smooth: each is the Gaussian mean, sigma `smoothing_count`
/// poses, of those around it, its directions too. `count` of them (at least 1), the first and the last at the ends of the smooth
/// way, between them at a steady speed: meters along the way, a radian of turning counting as one. `recorded` must not be empty.
std::vector<fresco::RigidTransform> recorded_path(std::span<const fresco::RigidTransform> recorded, double smoothing_count,
                                                  std::size_t count);

/// The directions of an orbit, radians to the right of where it looks ahead: from `first` to `last` and back, or once around.
struct OrbitArc
{
    double first = 0;
    double last = 0;
    bool around = true;
};

/// The widest run of directions in which at least half of the picture shows something. `shares` are the shares, 0 to 1, in
/// evenly spaced directions, the first ahead, each next one to the right of it. Around where that is so everywhere or nowhere.
OrbitArc orbit_arc(std::span<const double> shares);

/// `count` poses on a level circle of `radius_m` about the mean place of `recorded` (not empty), looking away from its middle and
/// down by `down_deg`. Ahead is as nearly as it can where the first of `recorded` looks. Around: from ahead to the right, at a
/// steady speed; along an arc: there and back, slow at its ends. The last stands one step before the first: shown in a loop it
/// never jumps.
std::vector<fresco::RigidTransform> orbit_path(std::span<const fresco::RigidTransform> recorded, double radius_m, double down_deg,
                                               std::size_t count, const OrbitArc& arc = {});
