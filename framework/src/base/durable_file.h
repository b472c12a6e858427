#pragma once

#include <fresco/value.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace fresco::host
{

/// Writes a file's data, or a folder's names, to the disk. Throws Error.
void sync_path(const std::filesystem::path& path);
/// Makes a folder and those above it that are missing, all on the disk. Throws Error naming the folder that cannot be made.
void make_folder(const std::filesystem::path& folder);

/// A map as one line of JSON, with the checksum of its text as the last entry, "checksum".
std::string checked_line(const Value& map);
/// The map of such a line, with its checksum; nothing if it is damaged.
std::optional<Value> map_of(std::string_view checked_line);

/// Writes a map as its checked_line, as write_durable_file does. Throws Error.
void write_record(const std::filesystem::path& file, const Value& map);
/// The map, with its checksum. Throws MissingInput if there is no such file, Error naming it if it is damaged.
Value read_record(const std::filesystem::path& file);

}  // namespace fresco::host
