#include "depth_agreement.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace fresco::inspect
{
namespace
{

/// Differences beyond this count as this.
constexpr double largest_difference = 0.1;
constexpr double near_depth_share = 0.03;

void cast_frame(const raycast::Scene& scene, const SampledDepth& frame, const Convention& convention, double focal_scale,
                std::size_t stride, DepthRatios& result)
{
    Camera camera{frame.camera.intrinsics, convention.correct(frame.camera.world_from_camera)};
    camera.intrinsics.fx *= focal_scale;
    camera.intrinsics.fy *= focal_scale;
    std::array<Vec3d, raycast::Scene::packet_size> directions;
    std::array<raycast::Hit, raycast::Scene::packet_size> hits;
    for (std::size_t begin = 0; begin < frame.samples.size();)
    {
        std::array<double, raycast::Scene::packet_size> measured{};
        std::size_t count = 0;
        for (; begin < frame.samples.size() && count < directions.size(); begin += stride, ++count)
        {
            const DepthSample& sample = frame.samples[begin];
            directions[count] = camera.ray(static_cast<double>(sample.x), static_cast<double>(sample.y));
            measured[count] = static_cast<double>(sample.depth);
        }
        scene.cast(camera.world_from_camera.translation, std::span(directions).first(count), std::span(hits).first(count));
        for (std::size_t i = 0; i < count; ++i)
        {
            result.seen += hits[i].found();
            result.fronts += hits[i].found() && hits[i].front;
            result.ratios.push_back(hits[i].found() ? hits[i].distance / measured[i] : 0);
        }
    }
}

}  // namespace

std::vector<DepthSample> sample_depth(const RasterF& depth, int columns)
{
    const int step = std::max(1, depth.width / columns);
    std::vector<DepthSample> samples;
    for (int y = step / 2; y < depth.height; y += step)
        for (int x = step / 2; x < depth.width; x += step)
            if (depth.at(x, y) > 0)
                samples.push_back({static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, depth.at(x, y)});
    return samples;
}

double DepthRatios::share(double scale, double tolerance) const
{
    if (ratios.empty())
        return 0;
    const auto begin = std::ranges::lower_bound(ratios, scale * (1 - tolerance));
    const auto end = std::ranges::upper_bound(ratios, scale * (1 + tolerance));
    return static_cast<double>(std::max<std::ptrdiff_t>(0, end - begin)) / static_cast<double>(ratios.size());
}

double DepthRatios::loss(double scale) const
{
    double sum = 0;
    for (const double ratio : ratios)
        sum += std::min(std::abs(ratio / scale - 1), largest_difference);
    return ratios.empty() ? largest_difference : sum / static_cast<double>(ratios.size());
}

double DepthRatios::median_error(double scale) const
{
    std::vector<double> errors;
    for (const double ratio : ratios)
        if (ratio > 0)
            errors.push_back(std::abs(ratio / scale - 1));
    if (errors.empty())
        return 1;
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::ranges::nth_element(errors, middle);
    return *middle;
}

double DepthRatios::best_scale() const
{
    double best = 1;
    std::ptrdiff_t most = 0;
    // Windows that begin at each ratio: [r, r (1 + d) / (1 - d)] holds what is within d of its middle.
    auto end = ratios.begin();
    for (auto begin = std::ranges::upper_bound(ratios, 0.0); begin != ratios.end(); ++begin)
    {
        const double last = *begin * (1 + near_depth_share) / (1 - near_depth_share);
        while (end != ratios.end() && *end <= last)
            ++end;
        if (end - begin > most)
        {
            most = end - begin;
            best = *(begin + most / 2);
        }
    }
    return best;
}

DepthRatios depth_ratios(const raycast::Scene& scene, const std::vector<SampledDepth>& frames, const Convention& convention,
                         double focal_scale, std::size_t stride, const Progress& progress)
{
    std::vector<DepthRatios> parts(frames.size());
    parallel_for(frames.size(), 1, progress.threads(),
                 [&](std::size_t frame, std::size_t)
                 {
                     progress.check_canceled();
                     cast_frame(scene, frames[frame], convention, focal_scale, stride, parts[frame]);
                 });
    DepthRatios all;
    for (const DepthRatios& part : parts)
    {
        all.ratios.insert(all.ratios.end(), part.ratios.begin(), part.ratios.end());
        all.seen += part.seen;
        all.fronts += part.fronts;
    }
    std::ranges::sort(all.ratios);
    return all;
}

}  // namespace fresco::inspect
