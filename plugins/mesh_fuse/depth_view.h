#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>

namespace fuse
{

/// The surface that one depth pixel saw, as a plane in the camera's frame that faces the camera.
struct PixelPlane
{
    fresco::Vec3f normal;
    float offset = 0;
    float weight = 0;  ///< Weight of the measurement; 0: nothing was measured.

    /// Of a point in the camera's frame: meters in front of the plane.
    float distance(fresco::Vec3f point) const { return dot(normal, point) + offset; }
};

/// What a depth picture says about the surface.
struct DepthView
{
    fresco::Camera camera;
    fresco::RasterF depth;  ///< Meters along the optical axis, 0 where nothing is believed.
    fresco::Raster<PixelPlane> planes;
};

/// Fits a plane to the depths around each pixel. The inverse of the depth is linear in a picture
/// of a plane, and the noise of structured light and stereo is about the same everywhere in it. Not believed are depths that are
/// no positive number or beyond `max_depth_m`, surfaces seen at less than 12 degrees, and pixels that fewer than six of their
/// eight neighbors continue: those beside depth edges, holes and the picture's border. A pixel counts by the cosine of the angle
/// at which it sees the surface over the square of its depth.
DepthView depth_view(const fresco::RasterF& depth, const fresco::Camera& camera, double max_depth_m);

}  // namespace fuse
