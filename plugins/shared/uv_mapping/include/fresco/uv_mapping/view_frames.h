#pragma once

/// \file From the views of uv maps back to their recorded frames and what their depth cameras measured. For stages that take uv
/// maps and frames.

#include <fresco/frames.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <vector>

namespace fresco
{

/// The frame that each view of the uv maps was made from: its index into `frames`. Throws Error naming the first view whose frame
/// is not there.
std::vector<std::size_t> frames_of_views(const UvMaps& maps, const Frames& frames);

/// Measured depth of the surface point that each pixel of the color camera sees: H x W like `map`, meters along
/// the depth camera's axis, nearest neighbor. 0 where it measured nothing or does not look, and where the map is invalid.
/// \param color     the color camera at full size
/// \param measured  the frame's depth picture in meters, 0 = none
RasterF sensor_depth(const UvMap& map, const Camera& color, const Camera& depth_camera, const RasterF& measured);

}  // namespace fresco
