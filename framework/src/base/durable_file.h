#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <string_view>

namespace fresco::host
{

/// Writes a file's data, or a folder's names, to the disk. Throws Error.
void sync_path(const std::filesystem::path& path);
/// Makes a folder and those above it that are missing, all on the disk. Throws Error naming the folder that cannot be made.
void make_folder(const std::filesystem::path& folder);

/// Writes a map as JSON with the checksum of its text as the last entry, "checksum", as write_durable_file does. Throws Error.
void write_record(const std::filesystem::path& file, const Value& map);
/// The map, with its checksum. Throws MissingInput if there is no such file, Error naming it if it is damaged.
Value read_record(const std::filesystem::path& file);

}  // namespace fresco::host
