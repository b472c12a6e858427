#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <iosfwd>

namespace fresco::host
{

/// What `asset.extras` of a GLB says of the file's origin, {versions, stages}. Reads only its header and JSON chunk. Throws Error
/// naming the file where it is no GLB, is cut short, or says nothing of it; MissingInput where there is no such file.
Value file_origin(const std::filesystem::path& file);

/// What `fresco describe room.glb` prints, for a terminal of `width`.
void write_file_origin(const std::filesystem::path& file, bool json, std::size_t width, std::ostream& out);

}  // namespace fresco::host
