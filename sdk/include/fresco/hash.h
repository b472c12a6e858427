#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

/// \file Whether something changed: contents of files and pictures, atlases, parts of cache keys.

namespace fresco
{

/// 128-bit content hash (XXH3) as 32 hexadecimal digits. Not cryptographic: it finds change and damage, not an attacker.
std::string content_hash(std::span<const std::byte> bytes);
std::string content_hash(std::string_view text);
/// The same for a file's bytes, streamed. Throws MissingInput if it cannot be read.
std::string file_hash(const std::filesystem::path& file);

}  // namespace fresco
