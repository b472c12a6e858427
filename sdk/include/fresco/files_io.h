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

/// Writes `file` whole or not at all: a temporary file `<file>.tmp` beside it, fsync, rename. Writers of one file, threads and
/// processes, wait for each other. Throws Error naming the file and the cause (disk full among them); the temporary file is
/// removed then. One that a killed process left is taken over by the next writer of the same file.
void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace fresco
