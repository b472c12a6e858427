#pragma once

#include "gather.h"

#include <fresco/image.h>
#include <fresco/parallel.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// \file Factors that make the pictures agree where they show the same surface: automatic exposure, white balance, vignetting.
/// Without them a texture has a step at every border between views. Solved once over all views, on a coarse texture's cells.

namespace fresco::from_frames
{

/// Color of one view in one cell of a coarse texture.
struct CellColor
{
    std::uint32_t cell = 0;
    float weight = 0;                ///< Above 0; 1 = a full observation.
    std::array<float, 3> log_rgb{};  ///< Natural logarithms of RGB in (0,1].
    std::array<float, 2> at{};       ///< Place in the picture, as TexelSample has it.
};

/// The cells of a gathered coarse texture that can be compared between exposures: neither nearly black nor saturated in any
/// channel. About 4096 at most, in whole squares of 8 x 8 cells chosen by a hash, so that all views choose the same ones; in the
/// order of the cells. `side`: cells a side of the texture.
std::vector<CellColor> cell_colors(std::span<const TexelSample> samples, int side);

/// Factors of a picture's channels, which change slowly over it: 12 x 9 nodes of RGB and a fourth 1, bilinear between them.
using Gains = RasterF;
Gains no_gains();
/// \param at  place in the picture, in [0,1], rightward and downward
std::array<float, 3> gain_at(const Gains& gains, const std::array<float, 2>& at);

/// The factors that make the views agree in the cells they share. Per channel, the logarithms x_v(p) = s_v + g_v(p), with one
/// number and one grid per view, minimize
///   Σ_cells Σ_views w (log c + x_v(p) - t_cell)²  +  Σ_v W_v (κ s_v² + mean over nodes of ρ g² + σ |∇g|²),
/// where the true colors t are eliminated and W_v is the weight of the cells that view v shares. This is the seam leveling of
/// Lempitsky and Ivanov (CVPR 2007) and Waechter et al. (ECCV 2014), which lets a smooth correction per view close the
/// differences at borders, for views that overlap rather than abut. The priors anchor it: errors that add up along a chain of
/// views fade over 1/√κ = 14 of them, and views that share no cell keep their colors. Weights follow the residuals (Geman and
/// McClure 1987, from a wide scale down to 0.1; one weight for all channels), so that highlights and occluders count little.
/// Conjugate gradients. Throws Canceled. \param views  CellColors per view, each in the order of the
/// cells
std::vector<Gains> exposure_gains(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const Progress& progress);

/// How well a blend of the views' cells shows what the views show.
struct BlendQuality
{
    /// Local log-color error per view: root mean square difference of the blend's and the picture's logarithms within squares of
    /// 8 x 8 cells, less each square's mean. Differences in exposure cost nothing, steps that the picture does not have do.
    std::vector<double> error;
    double total_error = 0;     ///< Over all views.
    float median_distance = 0;  ///< Median distance of the views' colors from the blend.
};

using Blender = std::function<std::array<float, 3>(std::span<const TexelSample>)>;

/// `blend` makes a cell's color from the views' samples with their gains, in the order of the views.
BlendQuality blend_quality(const std::vector<std::vector<CellColor>>& views, int side, const std::vector<Gains>& gains,
                           const Blender& blend);

/// For every view the smallest number of a view that it shares cells with, directly or through others.
std::vector<std::uint32_t> overlapping_groups(const std::vector<std::vector<CellColor>>& views, std::size_t cells);

}  // namespace fresco::from_frames
