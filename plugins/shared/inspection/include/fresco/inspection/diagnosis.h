#pragma once

#include <fresco/inspection/agreement.h>
#include <fresco/inspection/views.h>
#include <fresco/parallel.h>
#include <fresco/raycast/scene.h>

#include <string>
#include <utility>
#include <vector>

/// \file Decides whether the mesh, if there is one, poses, cameras and pictures of a recording belong together and names the
/// mistakes if not. The stage reports the findings and draws the recording with the mistakes corrected.

namespace fresco::inspect
{

/// A mistake, or a reason to look closer.
struct Finding
{
    std::string cause;     ///< Identifier for programs: "opengl_axes", …
    std::string text;      ///< The mistake and its remedy, for people.
    bool certain = false;  ///< The recording contradicts the mesh or itself; otherwise only a warning.
};

/// How well mesh and recording agree under one set of assumptions.
struct Fit
{
    double covered_share = 0;  ///< Share of the measured depths whose rays meet the mesh.
    double agreement = 0;      ///< Agreement::share of these.
    double median_error = 1;   ///< Relative difference of these; 1 if no ray meets the mesh.
    double in_front = 0;       ///< Share of the covered depths behind the mesh.
    double behind = 0;         ///< Share of the covered depths in front of it.
    double seen_through = 0;   ///< Share of the covered depths far behind it.
    bool fits = false;         ///< See fits().
    double edge_response = 0;  ///< See edge_response().
};

struct Diagnosis
{
    Fit recorded;
    Fit explained;  ///< With the assumptions below.
    std::vector<Finding> findings;

    Assumption assumption;

    std::size_t depths = 0;          ///< Number of depth samples compared.
    std::size_t outline_points = 0;  ///< Number of points compared with the color pictures' edges.
    double front_share = 1;          ///< Share of the agreeing places that cameras see from the front.
    /// Whether anything is assumed that was not recorded.
    bool explains() const { return !(assumption == Assumption{}); }
};

/// Frames that overlap contradict each other only if they see through more of what others measured; the rest may be hidden.
inline constexpr double hardly_in_front = 0.05;

/// Compares depths with the mesh where their rays meet it and searches for mistakes by explain_depths(). The color camera is
/// compared with the silhouettes of the depth pictures, without mesh and poses. Without depth, the mesh's own silhouettes replace
/// both. A mistake is reported only if it explains the recording clearly better than the recorded values. The same for any number
/// of threads. Throws Canceled.
///
/// Without a scene, the depths of each group of views are compared with each other.
Diagnosis diagnose(const raycast::Scene* scene, const std::vector<View>& views, const Progress& progress);

/// A view's cameras (color, depth) with the mistakes corrected, at the sizes of View::color and of the depth picture.
std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const View& view);

/// Corrects the mistakes in a view's depth picture: afterward it holds meters of the mesh along the optical axis, upright.
void correct_depth(const Diagnosis& diagnosis, const View& view, RasterF& depth);

}  // namespace fresco::inspect
