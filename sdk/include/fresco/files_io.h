#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// The whole file. Throws MissingInput if it cannot be opened, Error if it is not a regular file or larger than `limit_bytes`.
std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t limit_bytes = std::size_t{1} << 33U);
std::string read_text_file(const std::filesystem::path& file, std::size_t limit_bytes = std::size_t{1} << 26U);

/// How the names of files begin that are on their way to another name, as long as they have one. The rest of such a name is
/// random.
inline constexpr std::string_view temporary_file_prefix = ".fresco-";

/// Writes `file` whole or not at all: to a nameless file in the same folder (under a random name if the file system has no such
/// files), then renamed. Of several writers of one file one is last. Throws Error naming the file and the cause, such as a full
/// disk, and leaves nothing behind. Survives a crash of the program but not of the machine: the host flushes a stage's results to
/// the disk once, before it publishes them.
void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& file, std::string_view text);
/// The same, and flushes file and folder to the disk: for files outside a stage's results.
void write_durable_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_durable_file(const std::filesystem::path& file, std::string_view text);

}  // namespace fresco
