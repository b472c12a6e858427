#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file The frame around the planes of a packed uv map: its header and its compressed parts. Used by packed_uv_map.cpp and by
/// the fuzzer, which makes files with valid checksums.

namespace fresco::detail
{

enum PackedQuantity : std::size_t
{
    packed_u,
    packed_v,
    packed_cosine,
    packed_depth,
    packed_quantities
};

/// The parts of one quantity, in the file's order.
struct PackedParts
{
    std::uint32_t low = 0;
    std::uint32_t extra = 0;
    std::uint32_t large = 0;
};

/// What a packed uv map begins with.
struct PackedUvMapHeader
{
    static constexpr std::size_t bytes = 88;

    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t valid_pixels = 0;
    std::array<std::uint8_t, packed_quantities> bits{};  ///< Of the values' steps.
    float depth_steps_per_meter = 0;
    std::uint32_t mask = 0;                              ///< Bytes of the part.
    std::array<PackedParts, packed_quantities> parts{};  ///< Bytes of the parts.

    std::array<std::byte, bytes> write() const;
    /// Throws Error naming `source` and the offset unless the bytes begin with a header and have the parts that it lists behind
    /// it.
    static PackedUvMapHeader read(std::span<const std::byte> file, std::string_view source);
};

/// Throws Error: source, offset, what is wrong, and that the stage makes the map again.
[[noreturn]] void fail_packed(std::string_view source, std::size_t offset, std::string_view what);

/// Puts Zstandard frames, each with its size and checksum, behind one another. Not thread-safe.
class FrameWriter
{
  public:
    /// Leaves so many bytes at the beginning for the caller to fill.
    explicit FrameWriter(std::size_t reserved_bytes) : bytes_(reserved_bytes) {}

    /// Returns the frame's size; no bytes make no frame. Throws Error.
    std::uint32_t append(std::span<const std::uint8_t> contents);
    std::vector<std::byte> bytes() && { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
    std::unique_ptr<std::byte[]> scratch_;
    std::size_t scratch_bytes_ = 0;
};

/// Fills `bytes` with the contents of one frame; nothing for no bytes. Returns what is wrong, empty if nothing is: another size,
/// damage, bytes behind the frame. Thread-safe.
std::string read_frame(std::span<const std::byte> frame, std::span<std::uint8_t> bytes);

}  // namespace fresco::detail
