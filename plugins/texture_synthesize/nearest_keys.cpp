#include "nearest_keys.h"

#include <fresco/processor.h>

#include <algorithm>
#include <limits>

namespace fresco::synthesize
{
namespace
{

/// Panels that stay in the second-level cache while queries pass by.
constexpr std::size_t block_bytes = std::size_t{384} << 10U;
constexpr float never = 1e30F;

}  // namespace

const PatchKernel& patch_kernel()
{
    static const PatchKernel& kernel = fastest_of(avx512_patch_kernel(), avx2_patch_kernel(), base_patch_kernel());
    return kernel;
}

NearestKeys::NearestKeys(std::span<const float> features, const FeatureSizes& sizes, std::span<const float> weights, float lift,
                         const PatchKernel& kernel)
    : kernel_(kernel), sizes_(sizes), panels_((weights.size() + kernel.columns - 1) / kernel.columns)
{
    const std::size_t columns = kernel.columns;
    const std::size_t size = sizes.all();
    values_.assign(panels_ * (size + 2) * columns, 0.0F);
    for (std::size_t key = 0; key < panels_ * columns; ++key)
    {
        float* column = &values_[key / columns * (size + 2) * columns + key % columns];
        if (key >= weights.size())
        {
            column[(size + 1) * columns] = never;
            continue;
        }
        const float weight = weights[key];
        float norm = 0;
        for (std::size_t f = 0; f < size; ++f)
        {
            const float value = features[key * size + f];
            const bool is_squared = f < sizes.squared;
            norm += is_squared ? value * value : 0;
            column[f * columns] = is_squared ? -2 * weight * value : value;
        }
        column[size * columns] = weight;
        column[(size + 1) * columns] = weight * (norm + lift);
    }
}

void NearestKeys::find(const float* queries, std::size_t count, Nearest* out) const
{
    const std::size_t rows = kernel_.rows;
    const std::size_t columns = kernel_.columns;
    const std::size_t size = sizes_.all();
    const std::size_t inner = size + 2;
    const std::size_t groups = (count + rows - 1) / rows;
    std::vector<float> augmented(groups * rows * inner, 0.0F);
    for (std::size_t q = 0; q < count; ++q)
    {
        float* row = &augmented[q * inner];
        std::copy_n(queries + q * size, size, row);
        float norm = 0;
        for (std::size_t f = 0; f < sizes_.squared; ++f)
            norm += row[f] * row[f];
        row[size] = norm;
        row[size + 1] = 1;
    }
    std::vector<float> least(groups * rows * columns, std::numeric_limits<float>::infinity());
    std::vector<std::int32_t> where(least.size(), 0);
    const std::size_t panel_values = inner * columns;
    const std::size_t panels_per_block = std::max<std::size_t>(1, block_bytes / (panel_values * sizeof(float)));
    for (std::size_t block = 0; block < panels_; block += panels_per_block)
        for (std::size_t group = 0; group < groups; ++group)
            for (std::size_t panel = block; panel < std::min(block + panels_per_block, panels_); ++panel)
                kernel_.compare(&augmented[group * rows * inner], &values_[panel * panel_values], inner,
                                static_cast<std::int32_t>(panel), &least[group * rows * columns], &where[group * rows * columns]);
    for (std::size_t q = 0; q < count; ++q)
    {
        Nearest best{std::numeric_limits<std::uint32_t>::max(), std::numeric_limits<float>::infinity()};
        for (std::size_t c = 0; c < columns; ++c)
        {
            const float score = least[q * columns + c];
            const auto key = static_cast<std::uint32_t>(static_cast<std::size_t>(where[q * columns + c]) * columns + c);
            if (score < best.score || (score == best.score && key < best.key))
                best = {key, score};
        }
        out[q] = best;
    }
}

}  // namespace fresco::synthesize
