#pragma once

#include <fresco/camera.h>
#include <fresco/image_io.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// \file Checks of recorded pictures and their cameras.

namespace fresco::recordings
{

/// "640x480"
std::string size_text(int width, int height);

/// Throws MissingInput that counts `missing`, names the first of them and says `rule`; does nothing if it is empty.
void refuse_missing(const std::vector<std::string>& missing, std::string_view rule);

/// Throws Error naming `source` if the principal point is outside of `picture`, for which `k` is: then the intrinsics are for
/// pictures of another size.
void check_center(const Intrinsics& k, const std::string& source, const std::filesystem::path& picture);

/// Throws Error naming `file` if its EXIF data turns it, as ImageIo::check reports: the pose and lens that `source` states are
/// for the pixels as they are stored.
void check_not_turned(const std::filesystem::path& file, const ImageHeader& header, const std::string& source);

/// Throws Error naming `file` unless ImageIo::check found 16-bit gray in it, or did not look.
void check_depth_kind(const std::filesystem::path& file, const ImageHeader& header);

}  // namespace fresco::recordings
