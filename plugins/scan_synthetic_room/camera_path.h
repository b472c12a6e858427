#pragma once

#include "scene.h"

#include <fresco/camera.h>

#include <vector>

namespace room
{

/// The two cameras of the recorder. They differ in size and focal length, and stand 2.5 cm apart with a slight turn.
struct Recorder
{
    fresco::Intrinsics color;
    fresco::Intrinsics depth;
    fresco::RigidTransform color_from_depth;
};

Recorder make_recorder(int color_width, int color_height, int depth_width, int depth_height);

/// world_from_depth of `count` views: first a round along the walls that looks across the room and down beside the walls, then a
/// narrower one that looks outward, up and down. Positions keep clear of the furniture.
std::vector<fresco::RigidTransform> camera_path(const Scene& scene, int count, std::uint32_t seed);

}  // namespace room
