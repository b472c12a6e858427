#pragma once

#include <fresco/parallel.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file Which frames to choose so that few of them see everything well.

namespace fresco::numerics
{

/// A cell of a surface that a frame sees, and how well, in four bytes: a frame sees tens of thousands of them.
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

struct Pick
{
    std::size_t frame = 0;
    std::int64_t new_cells = 0;  ///< Cells that no frame picked before sees.
    friend bool operator==(const Pick&, const Pick&) = default;
};

/// Frames in the order in which a greedy choice takes them: each time the one that adds most to the sum, over all cells, of the
/// best worth with which a picked frame sees them; of equals the first. Ends when no frame adds anything. That sum has
/// diminishing returns, so the first k picks reach at least 63 % of the best that k frames can (Nemhauser, Wolsey and Fisher, "An
/// analysis of approximations for maximizing submodular set functions", 1978), and what a frame added in an earlier round bounds
/// what it adds now, so that few frames are looked at again (Minoux, "Accelerated greedy algorithms for maximizing submodular set
/// functions", 1978). `frames[i]`: what frame i sees, ascending cells < cell_count. Throws Canceled.
std::vector<Pick> greedy_order(const std::vector<std::vector<SeenCell>>& frames, std::size_t cell_count,
                               const Progress& progress);

/// How many of the cells the frames `chosen` see, each counted once.
std::int64_t cells_seen(const std::vector<std::vector<SeenCell>>& frames, std::span<const std::size_t> chosen,
                        std::size_t cell_count);

/// `count` of the numbers below `of`, evenly spread, ascending. \pre count <= of
std::vector<std::size_t> evenly_spread(std::size_t count, std::size_t of);

/// How many picks from the front see `target` (0..1) of all cells that any frame sees; at most `most`.
std::size_t picks_needed(const std::vector<Pick>& order, double target, std::size_t most);

}  // namespace fresco::numerics
