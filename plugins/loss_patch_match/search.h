#pragma once

#include <fresco/progress.h>

#include <torch/types.h>

namespace patch_match
{

/// Which style patch each patch of a picture is drawn to.
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

}  // namespace patch_match
