#pragma once

#include <fresco/image.h>
#include <fresco/uv_maps.h>

namespace bench
{

/// A view of a wall and of the floor before it, made from formulas: uv and depth as a camera in a room sees them, 4/3 as wide as
/// high. The wall's lower edge and the floor's far edge are apart in the texture, and the outermost column of pixels is not
/// valid. About a tenth of the texture is seen.
fresco::UvMap generated_view(int height_px);

/// RGB pictures: what a camera might see (smooth shades with edges), and a style (crossing strokes of a few colors).
fresco::RasterF generated_camera_picture(int width, int height);
fresco::RasterF generated_style(int width, int height);

}  // namespace bench
