#pragma once

#include <fresco/artifact.h>
#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/value.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// \file What several artifacts share in their on-disk forms.

namespace fresco::detail
{

Value to_value(const Camera& camera);
/// Throws Error naming the place of what is missing, or of a camera that is not usable.
Camera camera_from(const JsonPlace& place);

/// Reads a JSON file of the folder; throws Error naming it.
Value read_json_file(const std::filesystem::path& file);

/// The part of `path` below `base`, or nothing.
std::optional<std::string> below(const std::filesystem::path& path, const std::filesystem::path& base);

/// H x W (one channel) or H x W x C.
template <class T>
void write_raster(const std::filesystem::path& file, const Raster<T>& raster);
/// Throws Error naming the file if it is of another type or number of channels. `channels` 0: any from 1 to 4.
template <class T>
Raster<T> read_raster(const std::filesystem::path& file, int channels);

}  // namespace fresco::detail
