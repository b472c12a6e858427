#pragma once

#include "shown_texture.h"

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace fresco::optimize
{

/// The uv maps of some heights and the camera pictures that belong to them. References its inputs. Thread-safe.
class ViewSource
{
  public:
    /// `heights_px`: which heights to use, empty = all. `images` may be null where every picture is NPY. `start`: what frames
    /// without a picture show; null: none. Throws Error naming what is missing: a height, the frame of a view, its picture.
    ViewSource(const UvMaps& maps, const Frames& frames, const ImageIo* images, const std::vector<int>& heights_px,
               const Texture* start = nullptr);

    std::size_t view_count() const { return maps_.views.size(); }
    std::size_t level_count() const { return levels_.size(); }
    /// Ascending.
    int height_px(std::size_t level) const { return maps_.heights_px[levels_[level]]; }
    /// "seq-01/frame-000008"
    std::string name(std::size_t view) const { return maps_.views[view].sequence + "/" + maps_.views[view].frame; }
    /// Views that see the mesh at one height at least, in recorded order.
    std::vector<std::size_t> seeing_views() const;

    UvMap map(std::size_t view, std::size_t level) const { return maps_.load_map(view, levels_[level]); }
    /// What the depth camera measured of the pixels of `map`, as sensor_depth says. Throws Error if the frame has no depth
    /// picture.
    RasterF measured_depth(std::size_t view, const UvMap& map, float unmeasured) const;
    /// The camera picture as recorded, RGB; of a frame without one, what the start texture shows it at the largest height.
    Raster8 camera(std::size_t view) const;
    /// Whether some frame has no picture.
    bool shows_start() const { return start_ != nullptr; }
    /// Throws Error naming the first view whose frame has no depth picture.
    void check_measured_depth() const;

  private:
    const UvMaps& maps_;
    const Frames& frames_;
    const ImageIo* images_;
    std::vector<std::size_t> levels_;      ///< Into maps_.heights_px.
    std::vector<std::size_t> frame_of_;    ///< Per view: into frames_.frames.
    std::unique_ptr<ShownTexture> start_;  ///< Null where every frame has a picture.
};

}  // namespace fresco::optimize
