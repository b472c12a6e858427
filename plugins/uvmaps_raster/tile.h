#pragma once

#include "tile_kernel.h"

#include <array>
#include <cstdint>
#include <span>

namespace raster
{

/// Coordinates stay below this, so that products of their differences fit into 64 bits.
inline constexpr std::int32_t coordinate_limit = 1 << 29;

/// What pixels see in one rectangle of the picture. A pixel on an edge of two pieces that lie on its two sides belongs to one of
/// them: edge functions (Pineda, "A parallel algorithm for polygon rasterization", 1988) are computed in whole numbers, without
/// any rounding, and an edge counts among the inside of the piece to which it runs down, or to the right where it is level. The
/// nearest piece wins, of equally near ones the one of the first face; the order of drawing does not matter.
class Tile
{
  public:
    static constexpr int width = tile_width;
    static constexpr int height = tile_height;

    /// Empty, with (x, y) as its first pixel.
    void clear(int x, int y);

    /// Draws the pieces of those numbers, either way round; one without area covers nothing. `bits`: of the fraction of their
    /// coordinates.
    void draw(std::span<const Piece> pieces, std::span<const std::uint32_t> numbers, int bits,
              const TileKernel& kernel = fastest_kernel())
    {
        kernel.draw(pieces.data(), numbers.data(), numbers.size(), bits, x_, y_, keys_.data());
    }

    /// The faces of `columns` pixels from the tile's left border in its row `row`; no_face where nothing was drawn.
    void row(int row, int columns, std::uint32_t* faces) const;

  private:
    int x_ = 0;
    int y_ = 0;
    /// Nearness, whose bits are ordered as positive numbers are, above the complement of the face: the greatest is what is seen.
    std::array<std::uint64_t, std::size_t{tile_stride} * height> keys_{};
};

}  // namespace raster
