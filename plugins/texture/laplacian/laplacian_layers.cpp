#include "laplacian_layers.h"

#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <array>

namespace fresco::laplacian
{
namespace
{

/// Subtracts from `target` the lookup of `coarse` at the centers of target's texels.
void subtract_lookup(RasterF& target, const RasterF& coarse, int threads)
{
    const auto size = static_cast<float>(target.width);
    parallel_for(static_cast<std::size_t>(target.height), 16, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     std::array<float, 4> value{};
                     for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                         for (int x = 0; x < target.width; ++x)
                         {
                             sample_bilinear(coarse, (static_cast<float>(x) + 0.5F) / size,
                                             1 - (static_cast<float>(y) + 0.5F) / size, value.data());
                             for (int c = 0; c < target.channels; ++c)
                                 target.at(x, y, c) -= value[static_cast<std::size_t>(c)];
                         }
                 });
}

}  // namespace

std::vector<RasterF> laplacian_layers(const RasterF& picture, int count, int threads)
{
    std::vector<RasterF> layers{picture};
    for (int i = 1; i < count; ++i)
        layers.push_back(resized(layers.back(), layers.back().width / 2, layers.back().height / 2));
    for (std::size_t i = layers.size() - 1; i-- > 0;)
        for (std::size_t coarser = layers.size() - 1; coarser > i; --coarser)
            subtract_lookup(layers[i], layers[coarser], threads);
    return layers;
}

}  // namespace fresco::laplacian
