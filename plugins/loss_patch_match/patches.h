#pragma once

#include <torch/types.h>

#include <algorithm>
#include <cstdint>

namespace patch_match
{

constexpr int patch_size = 7;
constexpr int patch_values = 3 * patch_size * patch_size;

/// Patches with corners every `stride` pixels, the last ones moved to the picture's end so that every pixel is in one; row by
/// row.
struct PatchGrid
{
    std::int64_t width = 0;   ///< Of the picture.
    std::int64_t height = 0;  ///< Of the picture.
    std::int64_t stride = 1;

    std::int64_t columns() const { return places(width); }
    std::int64_t rows() const { return places(height); }
    std::int64_t count() const { return rows() * columns(); }
    std::int64_t x(std::int64_t index) const { return std::min(index % columns() * stride, width - patch_size); }
    std::int64_t y(std::int64_t index) const { return std::min(index / columns() * stride, height - patch_size); }
    /// Patches along a side.
    std::int64_t places(std::int64_t side) const { return side < patch_size ? 0 : (side - patch_size + stride - 1) / stride + 1; }
};

/// The grid's patches of `picture` (3 x H x W, float32) as rows in the order channel, y, x: count x 147.
torch::Tensor extract_patches(const torch::Tensor& picture, const PatchGrid& grid);

/// For each patch of the grid whether all its pixels are true in `mask` (H x W, bool): count, bool.
torch::Tensor whole_patches(const torch::Tensor& mask, const PatchGrid& grid);

/// `picture` averaged over 2x2 cells, and a mask with only those cells whose four pixels are valid.
torch::Tensor halved(const torch::Tensor& picture);
torch::Tensor halved_mask(const torch::Tensor& mask);

}  // namespace patch_match
