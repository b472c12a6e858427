#include <fresco/inspection/views.h>

#include "explain_depths.h"

#include <fresco/images/lab.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>

namespace fresco::inspect
{
namespace
{

constexpr std::size_t rows_per_block = 8;
constexpr int longest_gap = 2;
constexpr double depth_step = 0.08;
constexpr double gap_share = 0.04;
/// Keeps noise in the dark from counting as edges.
constexpr double darkest = 16;
/// More of a frame's outline adds no information.
constexpr std::size_t most_points = 400;
constexpr int around_px = 12;
constexpr double strongest = 4;

RasterF largest_of_nine(const RasterF& raster)
{
    RasterF result(raster.width, raster.height);
    for (int y = 0; y < raster.height; ++y)
        for (int x = 0; x < raster.width; ++x)
            for (int ny = std::max(0, y - 1); ny <= std::min(raster.height - 1, y + 1); ++ny)
                for (int nx = std::max(0, x - 1); nx <= std::min(raster.width - 1, x + 1); ++nx)
                    result.at(x, y) = std::max(result.at(x, y), raster.at(nx, ny));
    return result;
}

bool steps_back(const RasterF& depth, bool ends, int x, int y, int dx, int dy)
{
    const auto near = static_cast<double>(depth.at(x, y));
    for (int missing = 0; missing <= longest_gap; ++missing)
    {
        x += dx;
        y += dy;
        if (x < 0 || y < 0 || x >= depth.width || y >= depth.height)
            return false;
        if (const auto far = static_cast<double>(depth.at(x, y)); far > 0)
            return far > near * (1 + depth_step + missing * gap_share);
    }
    return ends;
}

}  // namespace

RasterF mesh_depth(const raycast::Scene& scene, const Camera& camera, const Progress& progress)
{
    const auto width = static_cast<std::size_t>(camera.intrinsics.width);
    RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    parallel_for(static_cast<std::size_t>(depth.height), rows_per_block, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<raycast::Hit> hits((end - begin) * width);
                     scene.cast_rows(camera, static_cast<int>(begin), static_cast<int>(end), hits);
                     for (std::size_t i = 0; i < hits.size(); ++i)
                         if (hits[i].found())
                             depth.values[begin * width + i] = static_cast<float>(hits[i].distance);
                 });
    return depth;
}

RasterF seen_from(const Camera& camera, const Camera& other, const RasterF& measured)
{
    const Intrinsics& k = camera.intrinsics;
    const Camera source{other.intrinsics.scaled_to(measured.width, measured.height), other.world_from_camera};
    RasterF depth(k.width, k.height);
    for (int y = 0; y < measured.height; ++y)
        for (int x = 0; x < measured.width; ++x)
        {
            const auto meters = static_cast<double>(measured.at(x, y));
            if (!(meters > 0))
                continue;
            const Vec3d seen = camera.project(source.world_from_camera.translation + source.ray(x + 0.5, y + 0.5) * meters);
            if (!(seen.z > 0 && seen.x >= 0 && seen.y >= 0 && seen.x < k.width && seen.y < k.height))
                continue;
            float& here = depth.at(static_cast<int>(seen.x), static_cast<int>(seen.y));
            if (here == 0 || seen.z < static_cast<double>(here))
                here = static_cast<float>(seen.z);
        }
    return depth;
}

RasterF nearest_sampled(const RasterF& depth, int width, int height)
{
    RasterF result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            result.at(x, y) = depth.at((2 * x + 1) * depth.width / (2 * width), (2 * y + 1) * depth.height / (2 * height));
    return result;
}

Raster8 outline(const RasterF& depth, bool ends)
{
    Raster8 result(depth.width, depth.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (depth.at(x, y) > 0)
                result.at(x, y) = steps_back(depth, ends, x, y, 1, 0) || steps_back(depth, ends, x, y, -1, 0) ||
                                  steps_back(depth, ends, x, y, 0, 1) || steps_back(depth, ends, x, y, 0, -1);
    return result;
}

std::vector<DepthSample> silhouette(const RasterF& depth)
{
    const Raster8 outlined = outline(depth, false);
    std::vector<DepthSample> points;
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
            if (outlined.at(x, y) != 0)
                points.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, depth.at(x, y)});
    const std::size_t stride = (points.size() + most_points - 1) / most_points;
    std::vector<DepthSample> result;
    for (std::size_t i = 0; i < points.size(); i += stride)
        result.push_back(points[i]);
    return result;
}

RasterF edge_strength(const Raster8& rgb)
{
    RasterF gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        gray.values[i] = static_cast<float>(std::log(luma(&rgb.values[3 * i]) + darkest));
    RasterF gradient(gray.width, gray.height);
    for (int y = 1; y < gray.height - 1; ++y)
        for (int x = 1; x < gray.width - 1; ++x)
            gradient.at(x, y) = std::hypot(gray.at(x + 1, y) - gray.at(x - 1, y), gray.at(x, y + 1) - gray.at(x, y - 1));
    RasterF strength = largest_of_nine(gradient);
    // Means over windows of 2 * around_px + 1 pixels a side, smaller at the borders, by sums from the corner.
    Raster<double> sums(gray.width + 1, gray.height + 1);
    for (int y = 0; y < gray.height; ++y)
        for (int x = 0; x < gray.width; ++x)
            sums.at(x + 1, y + 1) =
                static_cast<double>(strength.at(x, y)) + sums.at(x, y + 1) + sums.at(x + 1, y) - sums.at(x, y);
    const auto mean = [&](int left, int right, int top, int bottom)
    {
        left = std::max(0, left);
        top = std::max(0, top);
        right = std::min(gray.width, right);
        bottom = std::min(gray.height, bottom);
        return (sums.at(right, bottom) - sums.at(left, bottom) - sums.at(right, top) + sums.at(left, top)) /
               ((right - left) * (bottom - top));
    };
    const double everywhere = mean(0, gray.width, 0, gray.height);
    for (int y = 0; y < gray.height; ++y)
        for (int x = 0; x < gray.width; ++x)
        {
            const double usual = (mean(x - around_px, x + around_px + 1, y - around_px, y + around_px + 1) + everywhere) / 2;
            strength.at(x, y) =
                everywhere > 0 ? static_cast<float>(std::min(strongest, static_cast<double>(strength.at(x, y)) / usual)) : 1;
        }
    return strength;
}

namespace
{

/// Fewer tell nothing.
constexpr std::size_t fewest_points = 20;

double response(const EdgeView& view)
{
    if (view.outline.size() < fewest_points)
        return 0;
    const Intrinsics& k = view.camera;
    double sum = 0;
    for (const Vec2d point : view.outline)
    {
        const double x = k.fx * point.x + k.cx - 0.5;
        const double y = k.fy * point.y + k.cy - 0.5;
        if (x >= 0 && y >= 0 && x < view.edges->width - 1 && y < view.edges->height - 1)
            sum += numerics::bilinear(numerics::between(x), numerics::between(y),
                                      [&](int column, int row) { return static_cast<double>(view.edges->at(column, row)); }) -
                   1;
    }
    return sum / static_cast<double>(view.outline.size());
}

}  // namespace

void add_outline(EdgeView& view, const std::vector<Vec3d>& points)
{
    for (const Vec3d p : points)
        if (p.z > 0)
            view.outline.push_back({p.x / p.z, p.y / p.z});
}

std::vector<double> edge_responses(const std::vector<EdgeView>& views)
{
    std::vector<double> responses;
    for (const EdgeView& view : views)
        responses.push_back(response(view));
    return responses;
}

double edge_response(const std::vector<EdgeView>& views)
{
    double sum = 0;
    std::size_t telling = 0;
    for (const EdgeView& view : views)
    {
        sum += response(view);
        telling += view.outline.size() >= fewest_points;
    }
    return views.empty() ? 0 : sum / std::max(static_cast<double>(telling), 0.5 * static_cast<double>(views.size()));
}

namespace
{

constexpr int edge_height = 120;

std::vector<Vec2f> grid_pixels(const Raster8& rgb)
{
    const int step = std::max(1, rgb.width / grid_columns);
    std::vector<Vec2f> pixels;
    for (int y = step / 2; y < rgb.height; y += step)
        for (int x = step / 2; x < rgb.width; x += step)
            pixels.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F});
    return pixels;
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

/// See chosen_frames; 1 without depth.
std::size_t telling_spacing(const Frames& frames, const DepthReader& depth)
{
    constexpr std::size_t looks = 4;
    constexpr double telling_change = 0.04;
    const auto depths = [&](std::size_t i)
    {
        const Frame& frame = frames.frames[i];
        return frame.depth_picture.empty() ? RasterF() : nearest_sampled(depth(frame), grid_columns, grid_columns);
    };
    const std::size_t all = frames.frames.size();
    std::size_t spacing = 1;
    for (; 8 * spacing < all; spacing *= 2)
    {
        std::vector<double> changes;
        for (std::size_t look = 0; look < looks; ++look)
        {
            const std::size_t first = (2 * look + 1) * (all - spacing) / (2 * looks);
            const RasterF before = depths(first);
            const RasterF after = depths(first + spacing);
            for (std::size_t i = 0; i < std::min(before.values.size(), after.values.size()); ++i)
                if (before.values[i] > 0 && after.values[i] > 0)
                    changes.push_back(std::abs(std::log(static_cast<double>(after.values[i] / before.values[i]))));
        }
        if (changes.empty() || numerics::median(std::move(changes)) > telling_change)
            break;
    }
    return spacing;
}

}  // namespace

Camera at_height(const Camera& camera, int height)
{
    return {camera.intrinsics.scaled_to(camera.intrinsics.width_at(height), height), camera.world_from_camera};
}

std::vector<Chosen> chosen_frames(const Frames& frames, std::size_t count, bool with_mesh, const DepthReader& depth)
{
    const std::size_t all = frames.frames.size();
    std::vector<std::size_t> offsets{0};
    if (!with_mesh)
    {
        const std::size_t spacing = telling_spacing(frames, depth);
        offsets = {0, spacing, 2 * spacing, 4 * spacing};
        count = std::max<std::size_t>(1, count / 2);
    }
    const std::size_t firsts = all > offsets.back() ? all - offsets.back() : 1;
    count = std::min(count, firsts);
    std::vector<Chosen> chosen;
    for (std::size_t group = 0; group < count; ++group)
    {
        const std::size_t first = (2 * group + 1) * firsts / (2 * count);
        for (const std::size_t offset : offsets)
            if (first + offset < all && frames.frames[first + offset].sequence == frames.frames[first].sequence)
                chosen.push_back({first + offset, group});
    }
    return chosen;
}

View view_of(const Frames& frames, const Chosen& chosen, const DepthReader& read_depth, const ImageIo* images, bool with_color)
{
    const std::size_t index = chosen.frame;
    const Frame& frame = frames.frames[index];
    check_camera(frame.color, "the color camera of " + frame.sequence + "/" + frame.name);
    check_camera(frame.depth, "the depth camera of " + frame.sequence + "/" + frame.name);
    const bool has_depth = !frame.depth_picture.empty();
    View view;
    view.frame = index;
    const Camera& depth = has_depth ? frame.depth : frame.color;
    view.depth = {(has_depth ? frame.depth : frame.color).world_from_camera,
                  depth.intrinsics,
                  frame.color.intrinsics,
                  depth.world_from_camera.inverse() * frame.color.world_from_camera,
                  {},
                  chosen.group};
    view.color = at_height(frame.color, edge_height).intrinsics;
    if (has_depth)
    {
        const RasterF measured = read_depth(frame);
        view.depth.samples = sample_depth(measured, grid_columns);
        view.depth_is_empty = view.depth.samples.empty();
        view.silhouette = silhouette_of(measured);
    }
    if (with_color && !frame.color_picture.empty())
    {
        const Raster8 picture = resized(load_color(frame, images), view.color.width, view.color.height);
        view.edges = edge_strength(picture);
        view.pixels = grid_pixels(picture);
    }
    return view;
}

}  // namespace fresco::inspect
