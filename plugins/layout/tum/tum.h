#pragma once

#include <fresco/camera.h>
#include <fresco/recordings/lens.h>
#include <fresco/recordings/recorded_view.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tum
{

/// A picture of rgb.txt or depth.txt.
struct StampedPicture
{
    double time_s = 0;
    std::string name;    ///< Path below the recording's folder.
    std::string source;  ///< "rgb.txt:4".
};

/// A row of groundtruth.txt.
struct StampedPose
{
    double time_s = 0;
    fresco::RigidTransform world_from_camera;
    std::string source;
};

/// "timestamp filename" per line. Throws Error "source:line: …" for anything else, times that do not grow, a file that is cut.
std::vector<StampedPicture> parse_pictures(std::string_view text, std::string_view source);
/// "timestamp tx ty tz qx qy qz qw" per line: world_from_camera of the color camera. Throws as parse_pictures.
std::vector<StampedPose> parse_poses(std::string_view text, std::string_view source);

struct Association
{
    /// Without cameras; numbered by the line of their color picture, from 0.
    std::vector<fresco::recordings::RecordedView> views;
    std::size_t without_depth = 0;  ///< Color pictures left out because no depth picture is near.
    std::size_t without_pose = 0;   ///< Color pictures left out because no pose is near.
    double depth_gap_s = 0;         ///< The smallest max_gap_s with which one more of them would have a depth picture; 0: none.
    double pose_gap_s = 0;          ///< The smallest max_gap_s with which one more of them would have a pose; 0: none.
};

/// "the nearest depth picture is 0.035 s away, …" of those left out; empty if none was for its gap.
std::string gaps_text(const Association& found);

/// Each color picture with the depth picture and the pose that are nearest in time and at most `max_gap_s` away. A depth picture
/// serves the color picture that is nearest to it and no other. Throws Error if nothing is left, with the times of the three
/// lists and the smallest gaps.
Association associate(const std::vector<StampedPicture>& color, const std::vector<StampedPicture>& depth,
                      const std::vector<StampedPose>& poses, double max_gap_s, const std::filesystem::path& folder);

struct RecordingCamera
{
    fresco::Intrinsics intrinsics;  ///< Width 0: for pictures of any size.
    fresco::recordings::Lens lens;
    std::string source;  ///< "option camera: freiburg1", for errors.
};

/// The color camera that the makers of the data set calibrated, by the option's value: "freiburg1", "freiburg2", "freiburg3"
/// (its pictures are published undistorted), "ros_default" (what the recorder's driver assumes); "auto": by the number in the
/// name of the recording's folder. All are for 640x480 with the first pixel's center at (0, 0) there, (0.5, 0.5) here.
/// `intrinsics` (fx, fy, cx, cy, counted as there) and `distortion` (k1, k2, p1, p2, k3) go before it where they are not empty.
/// Throws Error naming the option for another count of numbers, and where "auto" cannot tell.
RecordingCamera recording_camera(std::string_view name, const std::vector<double>& intrinsics,
                                 const std::vector<double>& distortion, const std::filesystem::path& folder);

}  // namespace tum
