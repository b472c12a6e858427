#pragma once

#include <fresco/frames.h>
#include <fresco/uv_maps.h>

namespace fresco
{

/// What the depth camera measured of the surface point that each pixel of the color camera sees: H x W like `map`, meters along
/// the depth camera's axis, nearest neighbor. Where it measured nothing, or does not look, the result is `unmeasured`; 0 where
/// the map is invalid.
/// \param color     the color camera at full size
/// \param measured  the frame's depth picture in meters, 0 = none
RasterF sensor_depth(const UvMap& map, const Camera& color, const Camera& depth_camera, const RasterF& measured,
                     float unmeasured);

}  // namespace fresco
