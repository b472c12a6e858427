#pragma once

#include "detail.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/uv_mapping/into_camera.h>

#include <cstddef>
#include <optional>
#include <vector>

/// \file The surface that a picture shows, a point per block, by the frame's depth picture.

namespace fresco::sharpest
{

class SeenSurface
{
  public:
    /// Sees nothing.
    SeenSurface() = default;
    /// `depth`: meters, as the depth camera took it. `color`: the camera of the picture that `blocks` are of. Both cameras must
    /// have passed check_camera.
    SeenSurface(const RasterF& depth, const Camera& depth_camera, const Camera& color, const Detail& blocks);

    struct Point
    {
        Vec3f world;
        Vec2f pixel;        ///< Where this picture shows it.
        float depth_m = 0;  ///< 0: nothing is known there.
    };
    /// One per block; empty where the frame has no depth picture.
    const std::vector<Point>& points() const { return points_; }

    struct Place
    {
        std::size_t block;
        Vec2f pixel;
    };
    /// Where this picture shows a world point: nothing where it is outside or behind what is seen there.
    std::optional<Place> place_of(Vec3f world) const;

  private:
    Vec2d pixel_of(Vec3d in_camera) const;
    std::optional<std::size_t> block_at(Vec2d pixel) const;

    Intrinsics color_;
    std::optional<IntoCamera> camera_from_world_;
    int columns_ = 0;
    int rows_ = 0;
    std::vector<Point> points_;
};

}  // namespace fresco::sharpest
