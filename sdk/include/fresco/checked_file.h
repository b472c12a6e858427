#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fresco
{

/// As write_durable_file, with a checksum at the file's end: for what only this program reads back, such as checkpoints.
void write_checked(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_checked(const std::filesystem::path& file, std::string_view text);
/// What write_checked wrote. Throws MissingInput if there is no such file, Error naming it if its bytes are others.
std::vector<std::byte> read_checked(const std::filesystem::path& file);
std::string read_checked_text(const std::filesystem::path& file);

}  // namespace fresco
