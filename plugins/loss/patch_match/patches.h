#pragma once

/// \file Patches of pictures as rows of numbers: of the style, in few principal directions, and of the camera picture recolored
/// to it. For component.cpp.

#include <fresco/images/lab.h>

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
    std::int64_t width = 0;   ///< Width of the picture.
    std::int64_t height = 0;  ///< Height of the picture.
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

/// The patches of one style picture at one scale, ready to be searched.
struct StylePatches
{
    torch::Tensor patches;      ///< N x 147, float32
    torch::Tensor mean;         ///< 147
    torch::Tensor basis;        ///< 147 x D: principal directions, strongest first
    torch::Tensor keys;         ///< N x D: (patch - mean) · basis
    double total_variance = 0;  ///< Mean square distance of a patch to the mean.
};

/// Patches of `picture` (3 x H x W, both at least 7): every pixel's, or of the finest grid with at most `most` of them. D is
/// `dimensions`, at most 147. Deterministic for any thread count.
StylePatches make_style_patches(const torch::Tensor& picture, std::int64_t most, int dimensions);

/// (rows - mean) · basis: N x D of N x 147.
torch::Tensor project(const StylePatches& style, const torch::Tensor& rows);

/// The colors of `picture`: 3 x H x W, any float type, on any device.
fresco::ColorMoments color_moments(const torch::Tensor& picture);

/// `picture` (3 x H x W) with each color mapped and clamped to [0,1]; the same type and device.
torch::Tensor recolored(const torch::Tensor& picture, const fresco::ColorMap& map);

}  // namespace patch_match
