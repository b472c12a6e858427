#include "outline.h"

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

RasterF log_brightness(const Raster8& rgb)
{
    RasterF gray(rgb.width, rgb.height);
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        gray.values[i] = static_cast<float>(
            std::log(0.299 * rgb.values[3 * i] + 0.587 * rgb.values[3 * i + 1] + 0.114 * rgb.values[3 * i + 2] + darkest));
    return gray;
}

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

/// Means over the windows of 2 * around_px + 1 pixels a side, smaller at the borders.
class LocalMean
{
  public:
    explicit LocalMean(const RasterF& raster) : sums_(raster.width + 1, raster.height + 1)
    {
        for (int y = 0; y < raster.height; ++y)
            for (int x = 0; x < raster.width; ++x)
                sums_.at(x + 1, y + 1) =
                    static_cast<double>(raster.at(x, y)) + sums_.at(x, y + 1) + sums_.at(x + 1, y) - sums_.at(x, y);
    }
    double at(int x, int y) const
    {
        return mean(std::max(0, x - around_px), std::min(sums_.width - 1, x + around_px + 1), std::max(0, y - around_px),
                    std::min(sums_.height - 1, y + around_px + 1));
    }
    double everywhere() const { return mean(0, sums_.width - 1, 0, sums_.height - 1); }

  private:
    double mean(int left, int right, int top, int bottom) const
    {
        return (sums_.at(right, bottom) - sums_.at(left, bottom) - sums_.at(right, top) + sums_.at(left, top)) /
               ((right - left) * (bottom - top));
    }
    Raster<double> sums_;
};

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
    parallel_for(static_cast<std::size_t>(depth.height), rows_per_block, progress.threads(),
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
    const RasterF gray = log_brightness(rgb);
    RasterF gradient(gray.width, gray.height);
    for (int y = 1; y < gray.height - 1; ++y)
        for (int x = 1; x < gray.width - 1; ++x)
            gradient.at(x, y) = std::hypot(gray.at(x + 1, y) - gray.at(x - 1, y), gray.at(x, y + 1) - gray.at(x, y - 1));
    RasterF strength = largest_of_nine(gradient);
    const LocalMean mean(strength);
    const double everywhere = mean.everywhere();
    for (int y = 0; y < gray.height; ++y)
        for (int x = 0; x < gray.width; ++x)
        {
            const double usual = (mean.at(x, y) + everywhere) / 2;
            strength.at(x, y) =
                everywhere > 0 ? static_cast<float>(std::min(strongest, static_cast<double>(strength.at(x, y)) / usual)) : 1;
        }
    return strength;
}

}  // namespace fresco::inspect
