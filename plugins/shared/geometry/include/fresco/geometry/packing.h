#pragma once

#include <fresco/geometry/flatten.h>
#include <fresco/math.h>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// \file Puts flat charts into the unit square: from charts to an atlas. Shapes are found a place for as grids of bits.

namespace fresco::geometry
{

/// A grid of bits, row by row in 64-bit words; bit x of a row is bit x % 64 of word x / 64. Bits beyond the width are 0.
class Bitmap
{
  public:
    Bitmap() = default;
    Bitmap(int width, int height);

    int width() const { return width_; }
    int height() const { return height_; }
    std::span<const std::uint64_t> row(int y) const
    {
        return std::span(words_).subspan(stride_ * static_cast<std::size_t>(y), stride_);
    }
    std::span<std::uint64_t> row(int y) { return std::span(words_).subspan(stride_ * static_cast<std::size_t>(y), stride_); }
    bool get(int x, int y) const { return (row(y)[static_cast<std::size_t>(x) / 64] >> (x % 64) & 1) != 0; }
    /// Sets the bits [begin, end) of a row; both clamped to the width.
    void set(int y, int begin, int end);

    /// Sets every cell that a triangle touches (closed: its border counts), by the unit squares [x, x+1] x [y, y+1].
    void cover(std::span<const Vec2d, 3> triangle);
    /// By quarter turns, counter-clockwise where y points up.
    Bitmap turned(int quarters) const;

  private:
    int width_ = 0;
    int height_ = 0;
    std::size_t stride_ = 0;
    std::vector<std::uint64_t> words_;
};

struct Cell
{
    int x = 0;
    int y = 0;
    friend bool operator==(const Cell&, const Cell&) = default;
};

/// A square into which shapes are put so that the cells of any two are at least `gap` + 1 apart (in the larger of both
/// directions), and at least `margin` cells from the sides.
class ShapeBin
{
  public:
    ShapeBin(int size, int gap, int margin);

    /// The lowest and then leftmost place where the shape fits, in rows from `first_row` on, with its own lowest row above
    /// `end_row`; empty if it fits nowhere.
    std::optional<Cell> find(const Bitmap& shape, int first_row, int end_row) const;
    /// Takes the cells of the shape at that place.
    void put(const Bitmap& shape, Cell place);
    int size() const { return size_; }

  private:
    /// Makes a row's further levels from its first.
    void widen(int y);

    int size_;
    int gap_;
    int margin_;
    /// By level, row by row: the bits that tell of an occupied cell, or of the end of the row, among the 2^level from theirs on.
    /// Occupied cells are grown by the gap, so that a shape fits where it meets none.
    std::vector<Bitmap> levels_;
    std::vector<std::size_t> full_;  ///< By row: the lowest level that has only ones; what is longer is not kept up to date.
};

struct PackOptions
{
    int size_px;        ///< The texture for which charts share no texel.
    int gutter_px = 4;  ///< Texels between charts at that size: lookups stay apart in the first two mip-maps, too.
};

/// The turn (radians) that makes the axis-parallel box of the points smallest; 0 for fewer than three points or none apart.
double smallest_box_turn(std::vector<Vec2d> points);

/// The texcoords (3F, in [0,1]) that put every chart into the unit square at one scale, as large as it can find: turned to its
/// smallest box, then, largest first, to the lowest and leftmost free place in one of four directions on a grid of about 1024 x
/// 1024 cells. Throws Error if size_px is too small for that many charts, and Canceled.
std::vector<Vec2f> pack_charts(const FlatCharts& flat, const PackOptions& options, Progress& progress);

}  // namespace fresco::geometry
