#include <fresco/texturing/collapse.h>

#include <fresco/error.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace fresco::texturing
{

namespace
{
constexpr std::array<float, 3> network_mean_bgr{103.939F, 116.779F, 123.68F};

/// The two source texels of a full-size texel center along one axis.
struct Tap
{
    int low = 0;
    int high = 0;
    float share = 0;  ///< Of `high`.
};

std::vector<Tap> taps(int size, int layer_size)
{
    std::vector<Tap> result(static_cast<std::size_t>(size));
    for (int i = 0; i < size; ++i)
    {
        const double at = std::clamp((i + 0.5) * layer_size / size - 0.5, 0.0, layer_size - 1.0);
        const int low = static_cast<int>(at);
        const auto share = static_cast<float>(at - low);
        result[static_cast<std::size_t>(i)] = {low, share > 0 ? low + 1 : low, share};
    }
    return result;
}

void add_row(const RasterF& layer, const std::vector<Tap>& taps, int y, std::vector<float>& row)
{
    if (layer.width == static_cast<int>(taps.size()))
    {
        const float* const from = &layer.values[static_cast<std::size_t>(y) * row.size()];
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] += from[i];
        return;
    }
    const Tap& vertical = taps[static_cast<std::size_t>(y)];
    for (std::size_t x = 0; x < taps.size(); ++x)
        for (int c = 0; c < 3; ++c)
        {
            const Tap& t = taps[x];
            const float top = layer.at(t.low, vertical.low, c) * (1 - t.share) + layer.at(t.high, vertical.low, c) * t.share;
            const float bottom = layer.at(t.low, vertical.high, c) * (1 - t.share) + layer.at(t.high, vertical.high, c) * t.share;
            row[3 * x + static_cast<std::size_t>(c)] += top * (1 - vertical.share) + bottom * vertical.share;
        }
}

/// BGR around the network's mean to RGB in 0..1.
void network_to_rgb(std::vector<float>& row)
{
    for (std::size_t i = 0; i < row.size(); i += 3)
    {
        const std::array<float, 3> bgr{row[i], row[i + 1], row[i + 2]};
        for (std::size_t c = 0; c < 3; ++c)
            row[i + c] = (bgr[2 - c] + network_mean_bgr[2 - c]) / 255;
    }
}
}  // namespace

void check_texture(const Texture& texture)
{
    if (texture.values != "display" && texture.values != "network")
        throw Error("the texture's values are \"" + texture.values + "\"; expected \"display\" or \"network\"");
    if (texture.layers.empty())
        throw Error("the texture has no layers");
    const int size = texture.size_px();
    for (std::size_t i = 0; i < texture.layers.size(); ++i)
    {
        const RasterF& layer = texture.layers[i];
        if (layer.channels != 3 || layer.width < 1 || layer.width != layer.height || i >= 31 || layer.width != size >> i ||
            layer.width << i != size)
            throw Error(fmt::format("texture layer {} is {}x{}x{}; expected a square of side {} / 2^{} with 3 channels", i,
                                    layer.width, layer.height, layer.channels, size, i));
    }
    if (texture.seen.width != size || texture.seen.height != size || texture.seen.channels != 1)
        throw Error(
            fmt::format("the texture's seen mask is {}x{}; expected {}x{}", texture.seen.width, texture.seen.height, size, size));
}

RasterF collapse(const Texture& texture, const Progress& progress)
{
    const int size = texture.size_px();
    std::vector<std::vector<Tap>> layer_taps;
    for (const RasterF& layer : texture.layers)
        layer_taps.push_back(taps(size, layer.width));

    RasterF result(size, size, 3);
    const auto sum_row = [&](int y, std::vector<float>& row)
    {
        row.assign(static_cast<std::size_t>(size) * 3, 0.0F);
        for (std::size_t i = 0; i < texture.layers.size(); ++i)
            add_row(texture.layers[i], layer_taps[i], y, row);
        if (texture.values == "network")
            network_to_rgb(row);
        float* target = &result.at(0, y);
        for (std::size_t i = 0; i < row.size(); ++i)
        {
            if (!std::isfinite(row[i]))
                throw Error(fmt::format(
                    "the texture is not finite at texel ({}, {}): the optimization diverged; use a lower learning rate", i / 3,
                    y));
            target[i] = std::clamp(row[i], 0.0F, 1.0F);
        }
    };
    constexpr std::size_t rows_per_block = 32;
    parallel_for(static_cast<std::size_t>(size), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<float> row;
                     for (std::size_t y = begin; y < end; ++y)
                         sum_row(static_cast<int>(y), row);
                 });
    return result;
}

Raster8 to_bytes(const RasterF& rgb, const Progress& progress)
{
    Raster8 bytes(rgb.width, rgb.height, rgb.channels);
    constexpr std::size_t values_per_block = std::size_t{1} << 18U;
    parallel_for(rgb.values.size(), values_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                         bytes.values[i] = static_cast<std::uint8_t>(std::clamp(rgb.values[i], 0.0F, 1.0F) * 255.0F + 0.5F);
                 });
    return bytes;
}

}  // namespace fresco::texturing
