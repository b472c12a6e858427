#pragma once

#include "assumption.h"
#include "edges.h"
#include "views.h"

#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <string>
#include <utility>
#include <vector>

namespace fresco::inspect
{

/// What is wrong, or worth a look.
struct Finding
{
    std::string cause;     ///< A word for programs: "opengl_axes", …
    std::string text;      ///< What is wrong and what to do, for people.
    bool certain = false;  ///< Mesh and frames cannot both be right. Else it is a warning only.
};

/// How well mesh and recording agree under one set of assumptions.
struct Fit
{
    double covered_share = 0;  ///< Of the measured depths: their rays meet the mesh.
    double agreement = 0;      ///< Of these: Agreement::share.
    double median_error = 1;   ///< Relative difference of these; 1 where the mesh is never met.
    double in_front = 0;       ///< Of the covered depths: the mesh lies before what was measured, …
    double behind = 0;         ///< … and behind it.
    bool fits = false;         ///< See fits().
    double edge_response = 0;  ///< See edge_response().
};

struct Diagnosis
{
    Fit recorded;
    Fit explained;  ///< With all of the below taken into account.
    std::vector<Finding> findings;

    Assumption assumption;
    CameraChange color_change;
    bool color_by_depth_camera = false;  ///< Color pictures fit the depth camera, not their own.
    bool channels_exchanged = false;     ///< Red and blue.

    std::size_t depths = 0;          ///< Samples compared.
    std::size_t outline_points = 0;  ///< Compared with the color pictures' edges.
    /// Whether anything is assumed that was not recorded.
    bool explains() const { return !(assumption == Assumption{}) || !(color_change == CameraChange{}) || color_by_depth_camera; }
    double front_share = 1;  ///< Of the places that agree: cameras see the front of a face.
};

/// Judges whether mesh, poses, cameras and pictures belong together, and which mistakes explain it where they do not.
///
/// Depths are compared with the mesh where their rays meet it; mistakes are those of explain_depths(). The color camera is
/// compared with the silhouettes of the depth pictures: neither mesh nor poses enter. Without depth, the mesh's own silhouettes
/// stand in for both. Red and blue are compared with the colors of the mesh, if it has any. A mistake is found only if it
/// explains the recording clearly better than what was recorded. The same for any number of threads. Throws Canceled.
Diagnosis diagnose(const raycast::Scene& scene, const std::vector<View>& views, const Progress& progress);

/// A view's cameras (color, depth) as a diagnosis has them, at the sizes of View::color and of the depth picture.
std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const View& view);

/// Makes a depth picture of a view what a diagnosis takes it for: meters of the mesh along the optical axis, upright.
void correct_depth(const Diagnosis& diagnosis, const View& view, RasterF& depth);

}  // namespace fresco::inspect
