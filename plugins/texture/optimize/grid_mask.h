#pragma once

/// \file Masks of pixels on the coarser grids of features, and the features under them. For rendered_part.cpp.

#include "levels.h"

#include <fresco/image.h>

#include <torch/types.h>

#include <cstdint>
#include <vector>

namespace fresco::optimize
{

/// Cells of a feature grid that belong to a level.
struct GridMask
{
    torch::Tensor all;    ///< h x w, bool.
    torch::Tensor fine;   ///< h x w, bool: those of them that pass the angle filter.
    torch::Tensor index;  ///< N, int64: their row-major numbers, first of the fine ones, then of the others, each ascending.
    std::int64_t fine_count = 0;  ///< How many of the numbers are those of fine ones.

    std::int64_t cell_count() const { return all.numel(); }
    std::int64_t chosen_count() const { return index.numel(); }
};

/// Cell (i, j) takes the pixel at its center, ((i + 0.5) stride, (j + 0.5) stride): nearest neighbor; in the released protocols
/// its corner_pixel(). `all`, `fine`: H x W, 0 or 1; the grid is floor(H / stride) x floor(W / stride).
GridMask grid_mask(const Raster8& all, const Raster8& fine, int stride, Protocol protocol, const torch::Device& device);

/// The chosen cells of `features` (C x h x w) in the order of the mask's numbers: C x N, differentiable. Its gradient costs one
/// pass, not a scatter per cell.
torch::Tensor selected_cells(const torch::Tensor& features, const GridMask& mask);

/// Joins the cells selected from several grids, `fine_counts` fine ones first in each, with all fine ones first. In memory as
/// the first is; differentiable.
torch::Tensor side_by_side(const std::vector<torch::Tensor>& selected, const std::vector<std::int64_t>& fine_counts);

}  // namespace fresco::optimize
