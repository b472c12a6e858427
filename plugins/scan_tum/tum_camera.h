#pragma once

#include <fresco/camera.h>
#include <fresco/recordings/lens.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace tum
{

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
