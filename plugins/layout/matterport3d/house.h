#pragma once

#include <fresco/camera.h>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace matterport3d
{

/// The region (room) that each panorama stands in, -1 for none, of house_segmentations/<house>.house. Throws Error "source:line:
/// …": no such file, an unknown line, invalid numbers, other panoramas than its head counts, a file that
/// is cut.
std::map<std::string, int> parse_regions(std::string_view text, std::string_view source);

/// The house's camera file, undistorted_camera_parameters/<house>.conf; its stem is the house's name. Throws MissingInput if
/// there is none, Error if there are several.
std::filesystem::path camera_file(const std::filesystem::path& folder);

/// A line of undistorted_camera_parameters/<house>.conf.
struct ListedView
{
    std::string panorama;  ///< "03a8…", the tripod's place.
    std::string depth;     ///< File names.
    std::string color;
    std::vector<double> intrinsics;            ///< Row-major 3x3, as in the file.
    fresco::RigidTransform world_from_camera;  ///< OpenCV axes, meters.
    std::string source;                        ///< "file:line".
};

struct HouseCameras
{
    std::string depth_folder = "undistorted_depth_images";
    std::string color_folder = "undistorted_color_images";
    std::vector<ListedView> views;
};

/// Reads the lines `dataset`, `n_images`, `depth_directory`, `color_directory`, `intrinsics_matrix` (of the views below it) and
/// `scan`; poses have OpenGL axes there and are turned to OpenCV's. Throws Error "source:line: …": an unknown line, an
/// invalid file name, a view before any intrinsics, a pose that is not a rigid transform, a number of views other than
/// `n_images`, a truncated file.
HouseCameras parse_cameras(std::string_view text, std::string_view source);

/// The camera of a view, pictures of width x height. The data set counts rows from below: there the lower left pixel's center is
/// at (0, 0). Throws Error naming its source.
fresco::Intrinsics camera_of(const ListedView& view, int width, int height);

}  // namespace matterport3d
