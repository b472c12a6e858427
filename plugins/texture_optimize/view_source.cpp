#include "view_source.h"

#include <fresco/error.h>
#include <fresco/uv_mapping/sensor_depth.h>
#include <fresco/uv_mapping/view_frames.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::optimize
{

ViewSource::ViewSource(const UvMaps& maps, const Frames& frames, const ImageIo* images, const std::vector<int>& heights_px,
                       const Texture* start)
    : maps_(maps), frames_(frames), images_(images), frame_of_(frames_of_views(maps, frames))
{
    for (std::size_t level = 0; level < maps.heights_px.size(); ++level)
        if (heights_px.empty() || std::find(heights_px.begin(), heights_px.end(), maps.heights_px[level]) != heights_px.end())
            levels_.push_back(level);
    for (const int height : heights_px)
        if (std::find(maps.heights_px.begin(), maps.heights_px.end(), height) == maps.heights_px.end())
            throw Error(
                fmt::format("option \"heights_px\": no uv maps of {} px; found {}", height, fmt::join(maps.heights_px, ", ")));
    for (std::size_t view = 0; view < maps.views.size() && !start_; ++view)
    {
        if (!frames.frames[frame_of_[view]].color_picture.empty())
            continue;
        if (start == nullptr)
            throw Error(
                "frame " + name(view) +
                " has no color picture: wire 'start' to the texture of photographs (texture.from_frames) that such frames "
                "show");
        start_ = std::make_unique<ShownTexture>(*start);
    }
}

std::vector<std::size_t> ViewSource::seeing_views() const
{
    std::vector<std::size_t> views;
    for (std::size_t view = 0; view < maps_.views.size(); ++view)
    {
        const auto& counts = maps_.views[view].valid_pixels;
        if (std::any_of(levels_.begin(), levels_.end(), [&](std::size_t level) { return counts.at(level) > 0; }))
            views.push_back(view);
    }
    return views;
}

RasterF ViewSource::measured_depth(std::size_t view, const UvMap& map, float unmeasured) const
{
    const auto& frame = frames_.frames[frame_of_[view]];
    return sensor_depth(map, maps_.views[view].camera, frame.depth, load_depth(frame, images_), unmeasured);
}

Raster8 ViewSource::camera(std::size_t view) const
{
    const Frame& frame = frames_.frames[frame_of_[view]];
    if (start_ && frame.color_picture.empty())
        return start_->shown(maps_.load_map(view, levels_.back()));
    return load_color(frame, images_);
}

void ViewSource::check_measured_depth() const
{
    for (std::size_t view = 0; view < frame_of_.size(); ++view)
        if (frames_.frames[frame_of_[view]].depth_picture.empty())
            throw Error("frame " + name(view) + " has no depth picture: set level_depth: mesh");
}

}  // namespace fresco::optimize
