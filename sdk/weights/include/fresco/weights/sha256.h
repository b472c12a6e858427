#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace fresco::weights
{

/// SHA-256 (FIPS 180-4): 64 hexadecimal digits, lower case.
std::string sha256(std::span<const std::byte> bytes);
/// Streamed. Throws MissingInput if the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

/// Whether `digits` is the beginning of a SHA-256 that says enough: 8 to 64 hexadecimal digits in either case.
bool is_sha256_prefix(std::string_view digits);
/// Whether `hash` (lower case) begins with the digits of `prefix`, in either case.
bool has_sha256_prefix(std::string_view hash, std::string_view prefix);

}  // namespace fresco::weights
