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
