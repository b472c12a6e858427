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
};

/// optimiser.adam on the visible texels against all texels.
Table adam_table(const MethodSettings& settings);

/// texture.laplacian's lookup and sparse gradient against grid_sample with a dense gradient on every layer.
Table lookup_table(const MethodSettings& settings);

/// Each loss alone, and the default ones together; `vgg19`: a file with weights.
Table loss_table(const MethodSettings& settings, const std::filesystem::path& vgg19);

/// Encoding pictures once or again.
Table features_table(const MethodSettings& settings, const std::filesystem::path& vgg19);

}  // namespace bench
