#include "agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace fresco::inspect
{
namespace
{

constexpr double full_agreement = 0.01;
constexpr double no_agreement = 0.04;

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

MeasuredRay measured_ray(const DepthView& view, const DepthSample& sample, const Assumption& assumption)
{
    const Intrinsics k = assumption.depth_camera(view.depth, view.color);
    auto x = static_cast<double>(sample.x);
    auto y = static_cast<double>(sample.y);
    if (assumption.upside_down)
    {
        x = view.depth.width - x;
        y = view.depth.height - y;
    }
    const Vec3d direction{(x - k.cx) / k.fx, (y - k.cy) / k.fy, 1};
    const auto depth = static_cast<double>(sample.depth);
    return {direction, assumption.along_ray ? depth / length(direction) : depth};
}

RigidTransform depth_pose(const DepthView& view, const Assumption& assumption)
{
    const RigidTransform pose = assumption.pose(view.track);
    return assumption.by_color_camera ? pose * view.depth_from_color : pose;
}

void cast_samples(const raycast::Scene& scene, const DepthView& view, const Assumption& assumption, std::size_t stride,
                  const std::function<void(const WorldRay&, const raycast::Hit&)>& met)
{
    const RigidTransform pose = depth_pose(view, assumption);
    std::array<Vec3d, raycast::Scene::packet_size> directions;
    std::array<double, raycast::Scene::packet_size> depths{};
    std::array<raycast::Hit, raycast::Scene::packet_size> hits;
    for (std::size_t begin = 0; begin < view.samples.size();)
    {
        std::size_t count = 0;
        for (; begin < view.samples.size() && count < directions.size(); begin += stride, ++count)
        {
            const MeasuredRay ray = measured_ray(view, view.samples[begin], assumption);
            directions[count] = pose.direction(ray.direction);
            depths[count] = ray.depth;
        }
        scene.cast(pose.translation, std::span(directions).first(count), std::span(hits).first(count));
        for (std::size_t i = 0; i < count; ++i)
            met({pose.translation, directions[i], depths[i]}, hits[i]);
    }
}

std::vector<FrameRatios> depth_ratios(const raycast::Scene& scene, const std::vector<DepthView>& views,
                                      const Assumption& assumption, std::size_t stride)
{
    std::vector<FrameRatios> frames;
    frames.reserve(views.size());
    for (const DepthView& view : views)
    {
        FrameRatios& frame = frames.emplace_back();
        cast_samples(scene, view, assumption, stride,
                     [&](const WorldRay& ray, const raycast::Hit& hit)
                     {
                         frame.ratios.push_back(hit.found() ? static_cast<float>(hit.distance / ray.depth) : 0.0F);
                         frame.fronts.push_back(hit.front);
                     });
    }
    return frames;
}

double agreement_at(double ratio)
{
    return std::clamp((no_agreement - std::abs(ratio - 1)) / (no_agreement - full_agreement), 0.0, 1.0);
}

Agreement& Agreement::operator+=(const Agreement& other)
{
    samples += other.samples;
    agreeing += other.agreeing;
    in_front += other.in_front;
    behind += other.behind;
    return *this;
}

std::vector<Agreement> agreement(const std::vector<FrameRatios>& frames, double scale)
{
    std::vector<Agreement> result;
    for (const FrameRatios& frame : frames)
    {
        Agreement& sums = result.emplace_back();
        sums.samples = static_cast<double>(frame.ratios.size());
        for (const float recorded : frame.ratios)
            if (const double ratio = static_cast<double>(recorded) / scale; ratio > 0)
            {
                const double agrees = agreement_at(ratio);
                sums.agreeing += agrees;
                (ratio < 1 ? sums.in_front : sums.behind) += 1 - agrees;
            }
    }
    return result;
}

Agreement total(const std::vector<Agreement>& frames)
{
    Agreement all;
    for (const Agreement& frame : frames)
        all += frame;
    return all;
}

double best_scale(const std::vector<FrameRatios>& frames)
{
    std::vector<float> ratios;
    for (const FrameRatios& frame : frames)
        std::ranges::copy_if(frame.ratios, std::back_inserter(ratios), [](float ratio) { return ratio > 0; });
    std::ranges::sort(ratios);
    // Windows that begin at each ratio hold what agrees with their middle by half or more.
    constexpr double half = (full_agreement + no_agreement) / 2;
    constexpr auto width = static_cast<float>((1 + half) / (1 - half));
    double best = 1;
    std::ptrdiff_t most = 0;
    auto end = ratios.begin();
    for (auto begin = ratios.begin(); begin != ratios.end(); ++begin)
    {
        while (end != ratios.end() && *end <= *begin * width)
            ++end;
        if (end - begin > most)
        {
            most = end - begin;
            best = static_cast<double>(*(begin + most / 2));
        }
    }
    return best;
}

double median_error(const std::vector<FrameRatios>& frames, double scale)
{
    std::vector<double> errors;
    for (const FrameRatios& frame : frames)
        for (const float ratio : frame.ratios)
            if (ratio > 0)
                errors.push_back(std::abs(static_cast<double>(ratio) / scale - 1));
    if (errors.empty())
        return 1;
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::ranges::nth_element(errors, middle);
    return *middle;
}

double front_share(const std::vector<FrameRatios>& frames, double scale)
{
    double fronts = 0;
    double all = 0;
    for (const FrameRatios& frame : frames)
        for (std::size_t i = 0; i < frame.ratios.size(); ++i)
        {
            const double agrees = agreement_at(static_cast<double>(frame.ratios[i]) / scale);
            all += agrees;
            fronts += frame.fronts[i] ? agrees : 0;
        }
    return all > 0 ? fronts / all : 1;
}

}  // namespace fresco::inspect
