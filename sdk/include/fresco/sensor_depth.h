#pragma once

#include <fresco/frames.h>
#include <fresco/uv_maps.h>

namespace fresco
{

/// What the depth camera measured of the surface point that each pixel of the colour camera sees: H x W like `map`, metres along
/// the depth camera's axis, nearest neighbour. Where it measured nothing, or does not look, the result is `unmeasured`; 0 where
/// the map is invalid.
/// \param color     the colour camera at full size
/// \param measured  the frame's depth picture in metres, 0 = none
RasterF sensor_depth(const UvMap& map, const Camera& color, const Camera& depth_camera, const RasterF& measured,
                     float unmeasured);

}  // namespace fresco
