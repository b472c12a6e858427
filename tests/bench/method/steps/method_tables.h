#pragma once

#include "table.h"

#include <filesystem>
#include <vector>

namespace bench
{

struct MethodSettings
{
    std::vector<int> sizes_px{1024, 4096, 8192};  ///< Textures.
    std::vector<int> heights_px{256, 784};        ///< Views for lookups.
    int loss_height_px = 256;
    int threads = 1;
    int step_size_px = 4096;  ///< Texture of whole steps.
};

/// optimizer.adam on the visible texels against all texels.
Table adam_table(const MethodSettings& settings);

/// texture.laplacian's lookup and sparse gradient against grid_sample with a dense gradient on every layer.
Table lookup_table(const MethodSettings& settings);

/// The losses without weights and on VGG-19; `vgg19`: a file with weights.
Table loss_table(const MethodSettings& settings, const std::filesystem::path& vgg19);

/// Whole steps of the paper's method: as texture.optimize runs them, and as the released code does (whole frames, the camera
/// picture encoded in every step, every texel updated), with the same loss.
Table step_table(const MethodSettings& settings, const std::filesystem::path& folder);

/// Whole runs: how a step's time depends on the texture's size, and the memory on the number of frames.
Table run_table(const MethodSettings& settings, const std::filesystem::path& folder, const std::filesystem::path& vgg19);

/// Encoding pictures once or again.
Table features_table(const MethodSettings& settings, const std::filesystem::path& vgg19);

}  // namespace bench
