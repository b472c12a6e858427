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

/// Writes `file` whole or not at all: a new file beside it without a name (where the file system has no such files, one under a
/// random name), fsync, rename. Of several writers of one file one is last. Throws Error naming the file and the cause (disk full
/// among them); the new file is removed then.
void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace fresco
