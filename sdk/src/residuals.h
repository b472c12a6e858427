#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file How one quantity of a packed uv map becomes small numbers, held in bytes: the difference to left + above - above left,
/// what the pixel would hold if the surface went on flat. This is the Lorenzo predictor of two dimensions (Ibarria, Lindstrom,
/// Rossignac, Szymczak, "Out-of-core compression and decompression of large n-dimensional scalar fields", 2003); sums along
/// columns and rows undo it.

namespace fresco::detail
{

/// What one quantity of a map is stored as: per pixel a byte, and what does not fit into it.
struct ResidualPlanes
{
    std::vector<std::uint8_t> low;    ///< One per pixel.
    std::vector<std::uint8_t> extra;  ///< One per pixel, the residual's lowest bits where values have more than 16; else none.
    std::vector<std::uint8_t> large;  ///< Low bytes, then high bytes, of the residuals whose byte in `low` is 255.
};

/// Lowest bits of a residual that go to `extra`.
constexpr int extra_bits(int bits)
{
    return bits > 16 ? bits - 16 : 0;
}

/// Turns the rows of a map, from the top, into planes. Values are below 2^bits, bits in 1 … 22. Not thread-safe.
class ResidualEncoder
{
  public:
    ResidualEncoder(int width, int height, int bits);

    /// Values where valid is 0 are not read: the plane through the neighbors stands for them.
    void row(const std::uint32_t* values, const std::uint8_t* valid);
    ResidualPlanes planes() &&;

  private:
    std::size_t width_;
    int bits_;
    std::size_t next_ = 0;              ///< Pixel at which the next row begins.
    std::vector<std::uint32_t> above_;  ///< Modulo 2^32.
    std::vector<std::uint32_t> numbers_;
    std::vector<std::uint16_t> large_;
    ResidualPlanes planes_;
};

/// How many entries `large` has two bytes of.
std::size_t count_large(std::span<const std::uint8_t> low, int bits);

/// Gives the rows back. References the planes, whose sizes must fit: low and extra (if any) width x height, large 2 count_large.
class ResidualDecoder
{
  public:
    ResidualDecoder(int width, int bits, const std::uint8_t* low, const std::uint8_t* extra, std::span<const std::uint8_t> large);

    /// The next row's values, below 2^bits; where nothing is valid they mean nothing. Holds until the next call.
    const std::uint32_t* row();

  private:
    std::size_t width_;
    int bits_;
    const std::uint8_t* low_;
    const std::uint8_t* extra_;
    const std::uint8_t* large_low_;
    const std::uint8_t* large_high_;
    std::vector<std::uint32_t> above_;  ///< Modulo 2^32.
    std::vector<std::uint32_t> numbers_;
    std::vector<std::uint32_t> values_;
};

}  // namespace fresco::detail
