#pragma once

#include "assumption.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace fresco::inspect
{

/// A depth that was measured at a place of the depth picture.
struct DepthSample
{
    float x = 0;  ///< Pixel coordinates, …
    float y = 0;
    float depth = 0;  ///< … meters as recorded.
};

/// The depth pictures' part of a frame.
struct DepthView
{
    PoseTrack track;  ///< Of the depth camera.
    Intrinsics depth;
    Intrinsics color;
    RigidTransform depth_from_color;
    std::vector<DepthSample> samples;  ///< On a grid over the picture.
};

/// The measured pixels of a depth picture (0 = none) at the centers of a grid of about `columns` columns, row by row.
std::vector<DepthSample> sample_depth(const RasterF& depth, int columns);

/// The pixel's ray in the depth camera's axes, its z 1, and the depth along the optical axis, under an assumption. The depth's
/// scale is left out.
struct MeasuredRay
{
    Vec3d direction;
    double depth = 0;
};
MeasuredRay measured_ray(const DepthView& view, const DepthSample& sample, const Assumption& assumption);

/// world_from_camera of the camera that took the depth pictures, under an assumption.
RigidTransform depth_pose(const DepthView& view, const Assumption& assumption);

/// A measured pixel's ray in the world, and the depth along it.
struct WorldRay
{
    Vec3d origin;
    Vec3d direction;
    double depth = 0;
};

/// Calls `met` for every `stride`-th sample with its ray as `assumption` has it, but for the depth's scale, and what the ray
/// meets first. Single-threaded.
void cast_samples(const raycast::Scene& scene, const DepthView& view, const Assumption& assumption, std::size_t stride,
                  const std::function<void(const WorldRay&, const raycast::Hit&)>& met);

/// What the mesh has where a frame measured depths: mesh depth over measured depth, 0 where the mesh has nothing.
struct FrameRatios
{
    std::vector<float> ratios;
    std::vector<bool> fronts;  ///< The side of the face that was met.
};

/// Casts every `stride`-th sample's ray as `assumption` has it, but for the depth's scale. Single-threaded.
std::vector<FrameRatios> depth_ratios(const raycast::Scene& scene, const std::vector<DepthView>& views,
                                      const Assumption& assumption, std::size_t stride);

/// How much a measured depth agrees with the mesh: fully within 1 %, and not at all from 4 % on; linear between.
double agreement_at(double ratio);

/// Of one frame or more: how the measured depths agree with the mesh *where a ray meets it*.
struct Agreement
{
    double samples = 0;   ///< Measured depths.
    double agreeing = 0;  ///< Sum of agreement_at.
    double in_front = 0;  ///< The rest of those that meet the mesh before the measured surface: the sensor saw through it …
    double behind = 0;    ///< … and behind it: the mesh may lack what stands there.

    double covered() const { return agreeing + in_front + behind; }
    double covered_share() const { return samples > 0 ? covered() / samples : 0; }
    /// From 0 to 1. What may only be missing from the mesh counts half. 0 where nothing is covered.
    double share() const { return covered() > 0 ? agreeing / (agreeing + in_front + 0.5 * behind) : 0; }
    Agreement& operator+=(const Agreement& other);
};

/// Per frame, with depths multiplied by `scale`.
std::vector<Agreement> agreement(const std::vector<FrameRatios>& frames, double scale);
Agreement total(const std::vector<Agreement>& frames);

/// The depth scale that most ratios agree on; 1 where the mesh is never met.
double best_scale(const std::vector<FrameRatios>& frames);

/// Median relative difference of the depths that meet the mesh; 1 without any.
double median_error(const std::vector<FrameRatios>& frames, double scale);

/// Share of front sides among the depths that agree; 1 without any.
double front_share(const std::vector<FrameRatios>& frames, double scale);

}  // namespace fresco::inspect
