#pragma once

#include <torch/types.h>

#include <cstdint>

namespace patch_match
{

constexpr int patch_size = 7;
constexpr int patch_values = 3 * patch_size * patch_size;

/// Patches at the corners (x, y) = (i · stride, j · stride) that fit into a picture, row by row.
struct PatchGrid
{
    std::int64_t width = 0;   ///< Of the picture.
    std::int64_t height = 0;  ///< Of the picture.
    std::int64_t stride = 1;

    std::int64_t columns() const { return width < patch_size ? 0 : (width - patch_size) / stride + 1; }
    std::int64_t rows() const { return height < patch_size ? 0 : (height - patch_size) / stride + 1; }
    std::int64_t count() const { return rows() * columns(); }
    std::int64_t x(std::int64_t index) const { return index % columns() * stride; }
    std::int64_t y(std::int64_t index) const { return index / columns() * stride; }
};

/// The grid's patches of `picture` (3 x H x W, float32) as rows in the order channel, y, x: count x 147.
torch::Tensor extract_patches(const torch::Tensor& picture, const PatchGrid& grid);

/// For each patch of the grid whether all its pixels are true in `mask` (H x W, bool): count, bool.
torch::Tensor whole_patches(const torch::Tensor& mask, const PatchGrid& grid);

/// `picture` averaged over 2x2 cells, and a mask with only those cells whose four pixels are valid.
torch::Tensor halved(const torch::Tensor& picture);
torch::Tensor halved_mask(const torch::Tensor& mask);

}  // namespace patch_match
