#pragma once

/// \file Masks of pixels on the coarser grids of features, and the features under them. For rendered_part.cpp.

#include "levels.h"

#include <fresco/image.h>

#include <torch/types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace fresco::optimize
{

/// Which cells of a feature grid belong to a mask of pixels.
struct GridMask
{
    torch::Tensor cells;             ///< h x w, bool.
    torch::Tensor index;             ///< N, int64, ascending: the chosen cells' row-major numbers …
    std::vector<std::int64_t> near;  ///< … where the processor can read them, if it cannot read `index`.
    std::span<const std::int64_t> numbers() const;
};

/// Cell (i, j) takes the pixel at its center, ((i + 0.5) stride, (j + 0.5) stride): nearest neighbor; in the released protocols
/// its corner_pixel(). `mask`: H x W, 0 or 1; the grid is floor(H / stride) x floor(W / stride).
GridMask grid_mask(const Raster8& mask, int stride, Protocol protocol, const torch::Device& device);

/// The chosen cells of `features` (C x h x w): C x N, differentiable. Its gradient costs one pass, not a scatter per cell.
torch::Tensor selected_cells(const torch::Tensor& features, const GridMask& mask);

/// Of what selected_cells() gave for `all`, the cells of `part`, which are some of them; differentiable.
torch::Tensor selected_among(const torch::Tensor& selected, const GridMask& all, const GridMask& part);

}  // namespace fresco::optimize
