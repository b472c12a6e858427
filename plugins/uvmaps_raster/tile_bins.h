#pragma once

#include "projection.h"
#include "tile.h"

#include <bit>
#include <vector>

namespace raster
{

/// A picture cut into tiles.
struct Grid
{
    int width = 0;
    int height = 0;
    int bits = 0;  ///< Of the fraction of coordinates: 16, fewer for pictures wider or higher than 4096.
    double scale_x = 0;
    double scale_y = 0;
    double shift_x = 0;
    double shift_y = 0;
    int tiles_across = 0;
    std::uint32_t first_tile = 0;  ///< Tiles of all pictures are counted through, row by row.
    std::uint32_t end_tile = 0;

    Grid(const fresco::Intrinsics& intrinsics, std::uint32_t first_tile);

    std::int32_t x(const Projected& p) const { return rounded(p.x * scale_x + shift_x); }
    std::int32_t y(const Projected& p) const { return rounded(p.y * scale_y + shift_y); }

  private:
    static std::int32_t rounded(double value)
    {
        // Adding 1.5 * 2^52 leaves the nearest whole number in the low bits, quicker than functions that heed the rounding mode.
        return static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(value + 6755399441055744.0));
    }
};

/// The pieces of a run of faces, and which of them may cover pixels of which tile.
class TileBins
{
  public:
    /// Faces [begin, end) in all pictures. Keeps the memory of the last call.
    void fill(const fresco::Mesh& mesh, std::size_t begin, std::size_t end, const std::vector<Projected>& projected,
              const Frustum& frustum, const fresco::IntoCamera& into_camera, const std::vector<Grid>& grids);

    std::span<const std::uint32_t> pieces_of(std::uint32_t tile) const
    {
        return std::span(sorted_).subspan(starts_[tile], starts_[tile + 1] - starts_[tile]);
    }
    std::span<const Piece> pieces() const { return pieces_; }

  private:
    struct Entry
    {
        std::uint32_t tile;
        std::uint32_t piece;
    };

    void add(std::uint32_t face, const Projected& a, const Projected& b, const Projected& c, const std::vector<Grid>& grids);
    void sort(std::uint32_t tiles);

    std::vector<Piece> pieces_;
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> starts_;
    std::vector<std::uint32_t> sorted_;
};

}  // namespace raster
