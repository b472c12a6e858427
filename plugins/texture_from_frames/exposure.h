#pragma once

#include "gather.h"

#include <fresco/progress.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fresco::from_frames
{

/// What a view shows of one cell of a coarse texture.
struct CellColor
{
    std::uint32_t cell = 0;
    float weight = 0;                ///< Above 0; 1 = an observation in full.
    std::array<float, 3> log_rgb{};  ///< Natural logarithms of RGB in (0,1].
};

/// The cells of a gathered coarse texture whose colors say something about exposure: neither nearly black nor saturated in any
/// channel. At most 4096, chosen by a hash of the cell's number so that all views choose
/// the same ones; in the order of the cells.
std::vector<CellColor> cell_colors(const SampleBlocks& samples);

/// Factors of the three channels.
using Gain = std::array<double, 3>;

/// The factors that make the views agree where they see the same cells: per view and channel, x_v = log gain that minimizes
///   Σ_cells Σ_views w (log c + x_v - t_cell)²  +  λ Σ_v x_v²,
/// where the true colors t are eliminated. Weights are updated from the residuals (Geman and McClure 1987, from a wide scale
/// down to 0.1; one weight for all channels), so that highlights and what stands in front count little. The prior is weak, λ =
/// 0.04: a gain of e^±0.5 is as likely as a difference of 0.1 in a cell. It holds views that share nothing with others at 1, and
/// the mean of the logarithms at 0 in every group of views that see each other. Dense normal equations: N² x 8 bytes, solved by
/// Cholesky. One thread. Throws Canceled. \param views  CellColors per view, each in the order of the cells
std::vector<Gain> exposure_gains(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const Progress& progress);

}  // namespace fresco::from_frames
