#include "views.h"

#include "hypotheses.h"
#include "outline.h"

#include <algorithm>
#include <cmath>

namespace fresco::inspect
{
namespace
{

constexpr int edge_height = 120;
constexpr int grid_columns = 40;

/// The poses of the frames around, as far as a lag is looked for.
PoseTrack track_of(const Frames& frames, std::size_t index, Camera Frame::*camera)
{
    constexpr auto reach = static_cast<std::size_t>(lag_reach) + 1;
    const auto& all = frames.frames;
    const auto same = [&](std::size_t i) { return all[i].sequence == all[index].sequence; };
    std::size_t first = index;
    while (first > 0 && index - first < reach && same(first - 1))
        --first;
    PoseTrack track{{}, index - first};
    for (std::size_t i = first; i < all.size() && i <= index + reach && same(i); ++i)
        track.poses.push_back((all[i].*camera).world_from_camera);
    return track;
}

std::vector<ColorSample> sample_color(const Raster8& rgb)
{
    const int step = std::max(1, rgb.width / grid_columns);
    std::vector<ColorSample> samples;
    for (int y = step / 2; y < rgb.height; y += step)
        for (int x = step / 2; x < rgb.width; x += step)
            samples.push_back({static_cast<float>(x) + 0.5F,
                               static_cast<float>(y) + 0.5F,
                               {rgb.at(x, y, 0), rgb.at(x, y, 1), rgb.at(x, y, 2)}});
    return samples;
}

/// Found at the height of the edges, in pixels of the full picture.
std::vector<DepthSample> silhouette_of(const RasterF& depth)
{
    const int height = std::min(depth.height, edge_height);
    const int width = std::max(1, static_cast<int>(std::lround(double(depth.width) * height / depth.height)));
    auto points = silhouette(nearest_sampled(depth, width, height));
    for (DepthSample& point : points)
    {
        point.x *= static_cast<float>(depth.width) / static_cast<float>(width);
        point.y *= static_cast<float>(depth.height) / static_cast<float>(height);
    }
    return points;
}

}  // namespace

Camera at_height(const Camera& camera, int height)
{
    return {camera.intrinsics.scaled_to(camera.intrinsics.width_at(height), height), camera.world_from_camera};
}

View view_of(const Frames& frames, std::size_t index, const ImageIo& images)
{
    const Frame& frame = frames.frames[index];
    check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
    check_camera(frame.depth, "the depth camera of " + frame.sequence + "/" + frame.name);
    const bool has_depth = !frame.depth_picture.empty();
    View view;
    const Camera& depth = has_depth ? frame.depth : frame.color;
    view.depth = {track_of(frames, index, has_depth ? &Frame::depth : &Frame::color),
                  depth.intrinsics,
                  frame.color.intrinsics,
                  depth.world_from_camera.inverse() * frame.color.world_from_camera,
                  {}};
    view.color = at_height(frame.color, edge_height).intrinsics;
    if (has_depth)
    {
        const RasterF measured = load_depth(frame, &images);
        view.depth.samples = sample_depth(measured, grid_columns);
        view.silhouette = silhouette_of(measured);
    }
    if (!frame.color_picture.empty())
    {
        const Raster8 picture = resized(load_color(frame, &images), view.color.width, view.color.height);
        view.edges = edge_strength(picture);
        view.colors = sample_color(picture);
    }
    return view;
}

}  // namespace fresco::inspect
