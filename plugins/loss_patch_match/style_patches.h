#pragma once

#include "patches.h"

#include <torch/types.h>

#include <cstdint>

namespace patch_match
{

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

}  // namespace patch_match
