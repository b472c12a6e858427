#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace fresco::weights
{

/// SHA-256 (FIPS 180-4), fed in pieces of any size.
class Sha256
{
  public:
    Sha256();
    void add(std::span<const std::byte> bytes);
    /// 64 hexadecimal digits, lower case, of all that was added. Ends the computation: call it once.
    std::string hexadecimal();

  private:
    void block(const std::byte* bytes);

    std::array<std::uint32_t, 8> state_;
    std::array<std::byte, 64> pending_{};
    std::size_t pending_count_ = 0;
    std::uint64_t total_ = 0;
};

std::string sha256(std::span<const std::byte> bytes);
/// Streamed. Throws MissingInput if the file cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

/// Whether `digits` is the beginning of a SHA-256 that says enough: 8 to 64 hexadecimal digits in either case.
bool is_sha256_prefix(std::string_view digits);
/// Whether `hash` (lower case) begins with the digits of `prefix`, in either case.
bool has_sha256_prefix(std::string_view hash, std::string_view prefix);

}  // namespace fresco::weights
