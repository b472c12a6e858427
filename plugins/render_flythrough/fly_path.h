#pragma once

#include <fresco/math.h>

#include <cstddef>
#include <span>
#include <vector>

/// Poses (world_from_camera, OpenCV axes) along a recorded way, made smooth: each is the Gaussian mean, sigma `smoothing_count`
/// poses, of those around it, its directions too. `count` of them (at least 1), the first and the last at the ends of the smooth
/// way, between them at a steady speed: metres along the way, a radian of turning counting as one. `recorded` must not be empty.
std::vector<fresco::RigidTransform> recorded_path(std::span<const fresco::RigidTransform> recorded, double smoothing_count,
                                                  std::size_t count);

/// Which way is up by the poses: the mean of where their -y points. Unit length, (0, 0, 1) where that is nothing.
fresco::Vec3d mean_up(std::span<const fresco::RigidTransform> poses);

/// Once around: `count` poses on a level circle of `radius_m` about the mean place of `recorded`, looking away from its middle
/// and down by `down_deg`; the first looks as nearly as it can where the first of `recorded` does, then it turns to the right.
/// The last stands one step before the first: shown in a loop it never jumps.
std::vector<fresco::RigidTransform> orbit_path(std::span<const fresco::RigidTransform> recorded, double radius_m, double down_deg,
                                               std::size_t count);
