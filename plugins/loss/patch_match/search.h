#pragma once

/// \file Which of the style's patches is nearest, exactly, and how far it is. For component.cpp.

#include "patches.h"

#include <fresco/parallel.h>

#include <torch/types.h>

namespace patch_match
{

/// Assigns a style patch to each patch of a picture.
struct SearchInput
{
    torch::Tensor patches;    ///< Q x D, float32: keys of the picture's patches
    torch::Tensor guide;      ///< Q x D: keys of the guide picture's patches at the same places
    torch::Tensor style;      ///< N x D: keys of the style's patches, N >= 1
    double guide_weight = 0;  ///< d(i, j) = |patch_i - style_j|² + guide_weight · |guide_i - style_j|²
    double tolerance = 0;     ///< > 0; d(i, j) is divided by tolerance + min over i of d(i, j), so that style patches that
                              ///< nothing resembles are asked for too (after Granot et al., Drop the GAN, 2022)
};

/// For each i the j with the smallest divided distance, the first of equals: Q, int32. Memory does not grow with Q · N; the same
/// for any thread count. Throws fresco::Canceled.
torch::Tensor nearest_patches(const SearchInput& input, const fresco::Progress& progress);

/// Mean over patches of (|patch - style patch|² / scale + 1e-4)^(exponent / 2): a norm that lets a patch keep a few pixels of its
/// own. Kwatra et al., Texture optimization for example-based synthesis, 2005, section 3.2.
/// `picture` 3 x H x W of the grid's size, float32, differentiable; `nearest` int32, per patch of the grid a row of
/// `style` (N x 147, float32) or -1 for a patch that takes no part; `scale` > 0. The empty tensor where no patch takes part.
/// Any number of `threads` gives the same result.
torch::Tensor robust_distance(const torch::Tensor& picture, const PatchGrid& grid, const torch::Tensor& nearest,
                              const torch::Tensor& style, double scale, double exponent, int threads);

}  // namespace patch_match
