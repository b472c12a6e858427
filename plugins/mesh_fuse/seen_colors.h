#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>

/// H x W x 3: the color that the color camera sees at the surface point of each depth pixel, by the nearest pixel of `picture`
/// (of the color camera's size); of points beside the picture its border's, of pixels without depth (0) black. `depth`: meters
/// along the depth camera's optical axis. Surfaces that only the depth camera sees take the color of what hides them.
fresco::Raster8 seen_colors(const fresco::RasterF& depth, const fresco::Camera& depth_camera, const fresco::Raster8& picture,
                            const fresco::Camera& color_camera);
