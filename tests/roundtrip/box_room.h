#pragma once

#include <fresco/frames.h>
#include <fresco/mesh.h>

/// A room of 4 x 3 x 2.5 m with a block in it, seen from inside; every side is a rectangular chart of its own, 8.5 texels per
/// meter in a picture of box_room_texture_px.
fresco::Mesh box_room();
inline constexpr int box_room_texture_px = 160;

/// Eight views whose color and depth cameras differ in size, intrinsics and pose.
fresco::Frames box_room_frames();
