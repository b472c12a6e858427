#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace raster
{

/// A triangle in a picture. Coordinates are fixed-point with some number of fractional bits: pixel (i, j) has its centre at (i,
/// j).
struct Piece
{
    std::array<std::int32_t, 3> x;
    std::array<std::int32_t, 3> y;
    std::array<float, 3> nearness;  ///< Of the corners: 1 / depth, per metre; above 0.
    std::uint32_t face;             ///< Of the mesh.
};

/// Coordinates stay below this, so that products of their differences fit into 64 bits.
inline constexpr std::int32_t coordinate_limit = 1 << 29;

/// What pixels see in one rectangle of the picture. A pixel on an edge of two pieces that lie on its two sides belongs to one of
/// them: edge functions (Pineda, "A parallel algorithm for polygon rasterization", 1988) are computed in whole numbers, without
/// any rounding, and an edge counts among the inside of the piece to which it runs down, or to the right where it is level. The
/// nearest piece wins, of equally near ones the one of the first face; the order of drawing does not matter.
class Tile
{
  public:
    static constexpr int width = 64;
    static constexpr int height = 32;

    /// Empty, with (x, y) as its first pixel.
    void clear(int x, int y);

    /// Draws a piece, either way round; one without area covers nothing. `bits`: of the fraction of its coordinates.
    void draw(const Piece& piece, int bits);

    /// The faces of `columns` pixels from the tile's left border in its row `row`; no_face where nothing was drawn.
    void row(int row, int columns, std::uint32_t* faces) const;

  private:
    int x_ = 0;
    int y_ = 0;
    /// Nearness, whose bits are ordered as positive numbers are, above the complement of the face: the greatest is what is seen.
    std::array<std::uint64_t, std::size_t{width} * height> keys_{};
};

}  // namespace raster
