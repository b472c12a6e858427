#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace matterport3d
{

/// The region (room) that each panorama stands in, -1 for none, of house_segmentations/<house>.house. Throws Error "source:line:
/// …": no such file, an unknown line, invalid numbers, other panoramas than its head counts, a file that
/// is cut.
std::map<std::string, int> parse_regions(std::string_view text, std::string_view source);

/// The house's camera file, undistorted_camera_parameters/<house>.conf; its stem is the house's name. Throws MissingInput if
/// there is none, Error if there are several.
std::filesystem::path camera_file(const std::filesystem::path& folder);

}  // namespace matterport3d
