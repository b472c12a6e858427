#pragma once

#include <fresco/camera.h>
#include <fresco/math.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fresco::inspect
{

/// How the numbers of a pose were meant.
enum class Reading
{
    as_recorded,
    inverted,               ///< camera_from_world was taken for world_from_camera, or the reverse.
    transposed,             ///< Only the rotation is inverted: a matrix stored column by column.
    scalar_first,           ///< Quaternions w x y z were taken for x y z w.
    scalar_last,            ///< The reverse.
    inverted_scalar_first,  ///< As scalar_first, of poses that the reader inverts, such as COLMAP's.
    inverted_scalar_last
};

/// The pose that was meant. \pre the rotation is one, possibly with a reflection
RigidTransform meant(const RigidTransform& recorded, Reading reading);

/// The recorded poses around a frame, in the order of its sequence.
struct PoseTrack
{
    std::vector<RigidTransform> poses;
    std::size_t own = 0;  ///< The frame's own among them.
};

/// What is assumed of a recording; the default is what was recorded. Fields apply in this order.
struct Assumption
{
    // Poses.
    Reading reading = Reading::as_recorded;
    double lag_frames = 0;  ///< A picture belongs to the pose that is listed so many frames later.
    double pose_scale = 1;  ///< Multiplies positions.
    Mat3 camera_turn{};     ///< recorded_from_opencv: columns are OpenCV's right, down, forward in the recorder's camera axes.
    Mat3 world_turn{};      ///< mesh_from_world; may mirror.
    RigidTransform move{};  ///< mesh_from_world, after world_turn: by how much the mesh was moved.

    // Depth pictures.
    double depth_scale = 1;
    bool along_ray = false;        ///< They hold distances along the pixel's ray, not along the optical axis.
    bool upside_down = false;      ///< Turned by 180 degrees.
    bool by_color_camera = false;  ///< They fit the color camera.
    double size_scale = 1;         ///< Multiplies all intrinsics of the depth camera.
    double focal_scale = 1;        ///< Multiplies its focal lengths.

    /// world_from_camera in the mesh's world and unit, OpenCV axes. Its rotation reflects where world_turn does. Between two
    /// recorded poses positions are interpolated linearly, rotations by normalized quaternions; before the first and after the
    /// last pose the nearest one is used.
    RigidTransform pose(const PoseTrack& track) const;
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

/// A factor between units that is within 4 % of `scale` (1000, 0.001, 0.25, …), or `scale` itself.
double usual_scale(double scale);

}  // namespace fresco::inspect
