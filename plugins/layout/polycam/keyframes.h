#pragma once

#include <fresco/recordings/recorded_view.h>

#include <string_view>

namespace polycam
{

/// The camera in the file `view.pose`: width, height (0 where corrected cameras lack them), fx, fy, cx, cy (pixels, the first one's center at (0.5, 0.5)) and t_00 to
/// t_23, the rows of world_from_camera with OpenGL's camera axes, turned to OpenCV's here. Throws Error naming the file and the
/// key or byte.
void parse_camera(std::string_view text, fresco::recordings::RecordedView& view);

/// mesh_from_world of mesh_info.json: alignmentTransform, 16 numbers column by column. Throws Error naming `source`.
fresco::RigidTransform parse_alignment(std::string_view text, std::string_view source);

}  // namespace polycam
