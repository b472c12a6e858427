#pragma once

#include <fresco/uv_maps.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::cover
{

/// A cell of the grid over the texture that a frame sees, and how well, in four bytes: a frame sees tens of thousands of them.
class SeenCell
{
  public:
    static constexpr std::uint32_t most_cells = 1U << 24U;
    static constexpr std::uint32_t best_worth = 255;

    /// \pre cell < most_cells, worth <= best_worth
    SeenCell(std::uint32_t cell, std::uint32_t worth) : packed_(cell << 8U | worth) {}

    std::uint32_t cell() const { return packed_ >> 8U; }
    std::uint32_t worth() const { return packed_ & 255U; }
    friend bool operator==(const SeenCell&, const SeenCell&) = default;

  private:
    std::uint32_t packed_;
};

/// How much it is worth to see a cell: 1 to see it at all, and more to see it well.
struct WorthRules
{
    double angle_weight;      ///< Added when it is seen straight on, in proportion to the cosine of the angle.
    double sharpness_weight;  ///< Added when the picture is sharp, in proportion to its sharpness in [0,1].
};

/// The cells that valid pixels of `map` fall into, ascending, each with the best worth that a pixel gives it, scaled so that the
/// most possible is SeenCell::best_worth; never 0. Cells are numbered row by row in a square grid of cells_px x cells_px over the
/// texture, from the lower left. \pre cells_px² <= SeenCell::most_cells, sharpness in [0,1]
std::vector<SeenCell> seen_cells(const UvMap& map, int cells_px, double sharpness, const WorthRules& rules);

}  // namespace fresco::cover
