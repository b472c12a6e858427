#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/raycast/scene.h>

#include <cstddef>
#include <string>
#include <vector>

/// \file Compares measured depths with the mesh under an assumption about the recording, or with each other if there is no mesh,
/// and decides whether the assumption explains the recording better than the recorded values. explain_depths.h searches for such
/// assumptions; the diagnosis and the stage use the same figures to report how well a recording agrees.

namespace fresco::inspect
{

/// How the numbers of a pose were meant.
enum class Reading
{
    as_recorded,
    inverted,               ///< camera_from_world was read as world_from_camera, or the reverse.
    transposed,             ///< Only the rotation is inverted: a matrix stored column by column.
    scalar_first,           ///< Quaternions w x y z were read as x y z w.
    scalar_last,            ///< The reverse.
    inverted_scalar_first,  ///< Same as scalar_first, for poses that the reader inverts, such as COLMAP's.
    inverted_scalar_last
};

/// The pose that was meant. \pre the recorded rotation is orthogonal; it may reflect
RigidTransform meant(const RigidTransform& recorded, Reading reading);

/// Assumptions about a recording; by default none, so that it is taken as recorded. Fields apply in this order.
struct Assumption
{
    // Poses.
    Reading reading = Reading::as_recorded;
    double pose_scale = 1;  ///< Multiplies positions.
    Mat3 camera_turn{};     ///< recorded_from_opencv: columns are OpenCV's right, down, forward in the recorder's camera axes.
    Mat3 world_turn{};      ///< mesh_from_world; may mirror.

    // Depth pictures.
    double depth_scale = 1;
    bool along_ray = false;        ///< They hold distances along the pixel's ray, not along the optical axis.
    bool upside_down = false;      ///< Turned by 180 degrees.
    bool by_color_camera = false;  ///< They fit the color camera.
    double size_scale = 1;         ///< Multiplies all intrinsics of the depth camera.
    double focal_scale = 1;        ///< Multiplies its focal lengths.

    /// world_from_camera in the mesh's world and unit, OpenCV axes. Its rotation reflects where world_turn does.
    RigidTransform pose(const RigidTransform& recorded) const;
    /// The camera of the depth pictures, its size that of `depth`.
    Intrinsics depth_camera(const Intrinsics& depth, const Intrinsics& color) const;

    friend bool operator==(const Assumption&, const Assumption&) = default;
};

/// All of a camera's intrinsics times `size`, its focal lengths also times `focal`; the picture's size remains.
Intrinsics scaled(Intrinsics camera, double size, double focal);

/// The 24 rotations that map axes to axes; the identity first, then OpenGL's (y and z negated).
const std::vector<Mat3>& axis_rotations();

/// "+x -y -z": the axes that the columns of an axis rotation are.
std::string axis_names(const Mat3& turn);

/// A common factor between units (1000, 0.001, 0.25, …) within 4 % of `scale`, or `scale` itself.
double usual_scale(double scale);

/// A measured pixel of a depth picture.
struct DepthSample
{
    float x = 0;  ///< Pixel coordinates.
    float y = 0;
    float depth = 0;  ///< Meters as recorded.
};

/// The depth camera and picture of a frame.
struct DepthView
{
    RigidTransform pose;  ///< Recorded pose of the depth camera.
    Intrinsics depth;
    Intrinsics color;
    RigidTransform depth_from_color;
    std::vector<DepthSample> samples;  ///< On a grid over the picture, see sample_depth.
    std::size_t group = 0;             ///< Without a mesh, the views of a group are compared with each other.
};

/// Columns of the grid of samples.
inline constexpr int grid_columns = 40;

/// Whether the depth pictures' camera has the same rays as the color pictures'.
bool one_camera(const DepthView& view);

/// The measured pixels of a depth picture (0 = none) at the centers of a grid of about `columns` columns, row by row.
std::vector<DepthSample> sample_depth(const RasterF& depth, int columns);

/// A pixel's ray in the depth camera's axes, its z 1, and the depth along the optical axis.
struct MeasuredRay
{
    Vec3d direction;
    double depth = 0;
};

/// A sample's ray under an assumption. Assumption::depth_scale is not applied.
MeasuredRay measured_ray(const DepthView& view, const DepthSample& sample, const Assumption& assumption);

/// world_from_camera of the camera that took the depth pictures, under an assumption.
RigidTransform depth_pose(const DepthView& view, const Assumption& assumption);

/// Mesh depth over measured depth at the samples of a frame, 0 where the ray misses the mesh.
struct FrameRatios
{
    std::vector<float> ratios;
    std::vector<bool> fronts;  ///< Whether the ray met the front of the face.
};

/// The ratios of every `stride`-th sample under `assumption`, per frame. Assumption::depth_scale is not applied. Single-threaded.
///
/// Without a scene, the views of a group take the mesh's place for each other: a sample, as a point in the world, is seen by each
/// other view; the ratio is the point's depth there over the depth that this view measured (bilinear in the inverse between four
/// samples of one surface, or at a sample), 0 where it measured none. Below 1, the view saw through the point; above 1, something
/// may hide it. Only the quotient of the scales of poses and depths matters then.
std::vector<FrameRatios> depth_ratios(const raycast::Scene* scene, const std::vector<DepthView>& views,
                                      const Assumption& assumption, std::size_t stride);

/// How the measured depths of one or more frames agree with the mesh *where a ray meets it*.
struct Agreement
{
    double samples = 0;       ///< Measured depths.
    double agreeing = 0;      ///< Each depth counts fully within 1 %, not at all from 4 % on, linear between.
    double in_front = 0;      ///< Disagreement where the mesh lies before the measured surface: the sensor saw through it.
    double behind = 0;        ///< Disagreement where it lies behind: the mesh may lack an object.
    double seen_through = 0;  ///< Number of depths that it lies before by more than noise.

    double covered() const { return agreeing + in_front + behind; }
    double covered_share() const { return samples > 0 ? covered() / samples : 0; }
    /// From 0 to 1; 0 if nothing is covered. A depth in front of the mesh counts half: the mesh may be incomplete.
    double share() const { return covered() > 0 ? agreeing / (agreeing + in_front + 0.5 * behind) : 0; }
    friend Agreement operator+(const Agreement& a, const Agreement& b);
};

/// Per frame, with depths multiplied by `scale`.
std::vector<Agreement> agreement(const std::vector<FrameRatios>& frames, double scale);
Agreement total(const std::vector<Agreement>& frames);

/// The depth scale that most ratios agree on; 1 if no ray meets the mesh.
double best_scale(const std::vector<FrameRatios>& frames);

/// Median relative difference of the depths that meet the mesh; 1 without any.
double median_error(const std::vector<FrameRatios>& frames, double scale);

/// Share of front sides among the depths that agree; 1 without any.
double front_share(const std::vector<FrameRatios>& frames, double scale);

/// Whether `assumed` explains the recording and the recorded values do not: enough depths are covered, in enough frames; most of
/// those agree; at least half of the disagreement is gone; no fewer depths agree than before; and the gain is more than chance
/// over frames (bootstrap). Or it agrees as well and explains several times as many depths. Both hold the same frames.
/// `by_mesh`: against a mesh; frames among themselves are noisier, and less of the disagreement need be gone.
bool explains(const std::vector<Agreement>& recorded, const std::vector<Agreement>& assumed, bool by_mesh = true);

/// Whether the depths agree: at least 70 % of those that are covered; or, where the mesh is incomplete, most of those that it is
/// not merely behind.
bool fits(const Agreement& sum);

/// Whether `after` is a step in the right direction. Used when several mistakes occur together.
bool improves(const std::vector<Agreement>& before, const std::vector<Agreement>& after);

/// Whether a mean over frames of `after` - `before` is more than chance.
bool gains(const std::vector<double>& before, const std::vector<double>& after);

}  // namespace fresco::inspect
