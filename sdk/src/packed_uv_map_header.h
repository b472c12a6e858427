#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

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

}  // namespace fresco::detail
