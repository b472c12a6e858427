#pragma once

#include "depth_agreement.h"
#include "outline.h"

#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <string>
#include <utility>
#include <vector>

namespace fresco::inspect
{

/// What is looked at of a frame.
struct View
{
    SampledDepth depth;   ///< No samples: the frame has no depth picture.
    OutlinedFrame color;  ///< No edges: it has no color picture. The outline is filled by `diagnose`.
};

/// A usual mistake that explains the recording clearly better than the recording itself.
struct Finding
{
    std::string cause;  ///< A word for programs: "opengl_axes", …
    std::string text;   ///< What is wrong and what to do, for people.
};

/// How well mesh and recording agree, under one set of assumptions.
struct Agreement
{
    double depth_share = 0;         ///< Of the measured depths: within 3 % of the mesh's.
    double depth_seen_share = 0;    ///< Of the measured depths: there is something of the mesh.
    double depth_median_error = 1;  ///< Relative; 1 where the mesh is never seen.

    /// Whether nearly all depths that can agree do: the mesh may end before the depths do.
    bool depth_clear() const { return depth_share >= 0.75 * depth_seen_share; }
    double edge_response = 0;  ///< See edge_response().
};

/// Of the depth camera, as color_focal_reach.
inline constexpr double depth_focal_reach = 0.3;

struct Diagnosis
{
    Agreement recorded;
    Agreement explained;  ///< With all of the below taken into account.
    std::vector<Finding> findings;

    Convention convention;
    double depth_scale = 1;  ///< Multiplies depths.
    double depth_focal_scale = 1;
    bool depth_by_color_camera = false;  ///< Depth pictures fit the color camera, not their own.
    CameraChange color_change;

    std::size_t depths = 0;          ///< Samples compared.
    std::size_t outline_points = 0;  ///< As recorded.
    double seen_share = 0;           ///< Of the color cameras' pixels, as explained: they see the mesh, whichever side.
    double front_share = 0;          ///< Of these: they see the front of a face.
};

/// Judges whether mesh, poses, cameras and pictures belong together, and where they do not, which of the usual mistakes explains
/// it: axes, inverted poses, units, a turned world, cameras taken for each other, focal lengths, faces turned inside out.
/// Depths decide where there are any, else the pictures' edges along the mesh's outline. A mistake is named only if what it
/// assumes fits clearly better than what was recorded, and well: where depths do not agree even so, nothing is explained but
/// that. The same for any number of threads. Throws Canceled.
Diagnosis diagnose(const raycast::Scene& scene, std::vector<View>& views, const Progress& progress);

/// A frame's cameras (color, depth) as a diagnosis has them.
std::pair<Camera, Camera> explained_cameras(const Diagnosis& diagnosis, const Camera& color, const Camera& depth);

}  // namespace fresco::inspect
