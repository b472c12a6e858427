#include <fresco/layered_texture/layer_view.h>

#include <fresco/error.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace fresco
{
namespace
{

/// Position of a coordinate in [0,1] between the texels of one axis.
struct Place
{
    std::int32_t first;
    float share;  ///< Weight of the texel after `first`.
};

Place place(float coordinate, int size, TexelGrid grid)
{
    const float texels =
        grid == TexelGrid::centers ? coordinate * static_cast<float>(size) - 0.5F : coordinate * static_cast<float>(size - 1);
    const float x = std::clamp(texels, 0.0F, static_cast<float>(size - 1));
    const auto first = std::min(static_cast<std::int32_t>(x), static_cast<std::int32_t>(size - 2));
    return {first, x - static_cast<float>(first)};
}

float corner_weight(std::uint32_t corner, float right, float down)
{
    return ((corner & 1U) != 0 ? right : 1 - right) * ((corner & 2U) != 0 ? down : 1 - down);
}

}  // namespace

ValidPixels valid_pixels(const UvMap& map)
{
    ValidPixels result;
    result.width = map.valid.width;
    result.height = map.valid.height;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        if (map.valid.values[i] == 0)
            continue;
        const float u = map.uv.values[2 * i];
        const float v = map.uv.values[2 * i + 1];
        if (!std::isfinite(u) || !std::isfinite(v))
            throw Error(fmt::format("a uv map is not finite at pixel {}, {}; make the uv maps again",
                                    i % static_cast<std::size_t>(map.valid.width),
                                    i / static_cast<std::size_t>(map.valid.width)));
        result.pixels.push_back(static_cast<std::int32_t>(i));
        result.uv.push_back(u);
        result.uv.push_back(v);
    }
    return result;
}

LayerView::LayerView(const ValidPixels& pixels, int size, TexelGrid grid) : size_(size)
{
    const std::size_t count = pixels.pixels.size();
    base_.reserve(count);
    fraction_.reserve(2 * count);
    std::vector<std::uint64_t> entries;
    entries.reserve(4 * count);
    for (std::size_t i = 0; i < count; ++i)
    {
        const Place column = place(pixels.uv[2 * i], size, grid);
        const Place row = place(1 - pixels.uv[2 * i + 1], size, grid);
        const std::int32_t base = row.first * size + column.first;
        base_.push_back(base);
        fraction_.push_back(column.share);
        fraction_.push_back(row.share);
        for (std::uint32_t corner = 0; corner < 4; ++corner)
        {
            if (!(corner_weight(corner, column.share, row.share) > 0))
                continue;
            const std::int32_t texel = base + ((corner & 1U) != 0 ? 1 : 0) + ((corner & 2U) != 0 ? size : 0);
            entries.push_back(static_cast<std::uint64_t>(texel) << 32U | (4 * static_cast<std::uint64_t>(i) + corner));
        }
    }
    numerics::sort_by_upper_half(entries, static_cast<std::uint32_t>(size) * static_cast<std::uint32_t>(size) - 1);

    lookups_.reserve(entries.size());
    for (const auto entry : entries)
    {
        const auto texel = static_cast<std::int64_t>(entry >> 32U);
        if (texels_.empty() || texels_.back() != texel)
        {
            texels_.push_back(texel);
            offsets_.push_back(static_cast<std::uint32_t>(lookups_.size()));
        }
        lookups_.push_back(static_cast<std::uint32_t>(entry));
    }
    offsets_.push_back(static_cast<std::uint32_t>(lookups_.size()));
    texels_.shrink_to_fit();
    offsets_.shrink_to_fit();
}

void LayerView::add_lookup(const float* texels, std::size_t begin, std::size_t end, float* out) const
{
    for (std::size_t i = begin; i < end; ++i)
    {
        const float* upper = texels + 3 * static_cast<std::ptrdiff_t>(base_[i]);
        const float* lower = upper + 3 * static_cast<std::ptrdiff_t>(size_);
        const float fx = fraction_[2 * i];
        const float fy = fraction_[2 * i + 1];
        for (int c = 0; c < 3; ++c)
        {
            const float top = upper[c] * (1 - fx) + upper[c + 3] * fx;
            const float bottom = lower[c] * (1 - fx) + lower[c + 3] * fx;
            out[3 * i + static_cast<std::size_t>(c)] += top * (1 - fy) + bottom * fy;
        }
    }
}

float LayerView::weight(std::uint32_t lookup) const
{
    const std::size_t pixel = lookup / 4;
    return corner_weight(lookup % 4, fraction_[2 * pixel], fraction_[2 * pixel + 1]);
}

void LayerView::gather(const float* gradient, std::size_t begin, std::size_t end, float* out) const
{
    for (std::size_t t = begin; t < end; ++t)
    {
        std::array<float, 3> sum{};
        for (std::uint32_t k = offsets_[t]; k < offsets_[t + 1]; ++k)
        {
            const float w = weight(lookups_[k]);
            const float* g = gradient + 3 * static_cast<std::size_t>(lookups_[k] / 4);
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += w * g[c];
        }
        std::copy(sum.begin(), sum.end(), out + 3 * t);
    }
}

}  // namespace fresco
