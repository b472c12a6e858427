#pragma once

#include <fresco/value.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// \file Hashes of large files piece by piece, so that a result of gigabytes is verified on all cores, and only the pieces
/// that are read. The store writes and checks them.

namespace fresco::host
{

/// Files of a result are hashed and verified in pieces of this size.
inline constexpr std::size_t chunk_bytes = std::size_t{4} << 20U;

/// One file of a result.
struct StoredFile
{
    std::string path;  ///< Relative to the result's folder, '/'-separated.
    std::uint64_t size = 0;
    std::vector<std::string> chunks;  ///< content_hash of each piece.
};

/// Streams a file. Throws Error naming it if it cannot be read.
StoredFile hash_chunks(const std::filesystem::path& root, const std::string& relative_path);

/// Damage of the file below `root`, with the offset of the first damaged piece, or nothing.
std::optional<std::string> find_damage(const std::filesystem::path& root, const StoredFile& expected);

Value to_value(const StoredFile& file);
StoredFile stored_file_from(const Value& value);

}  // namespace fresco::host
