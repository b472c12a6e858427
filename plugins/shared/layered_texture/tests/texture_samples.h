#pragma once

#include <fresco/layered_texture/layer_view.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/Parallel.h>
#include <ATen/ops/equal.h>

#include "catch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

/// \file Pictures and uv maps of random numbers, and what any texture made of layers must hold.

namespace texture_samples
{

using namespace fresco;

/// Values in [0, 1).
inline RasterF random_picture(int width, int height, int channels, std::uint64_t seed)
{
    Random random(seed);
    RasterF picture(width, height, channels);
    for (auto& value : picture.values)
        value = static_cast<float>(random.uniform());
    return picture;
}

/// uv all over the texture and a little beyond, the first two in corners of it; a fifth of the other pixels invalid.
inline UvMap random_map(int width, int height, std::uint64_t seed)
{
    UvMap map{random_picture(width, height, 2, seed), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    for (auto& value : map.uv.values)
        value = value * 1.2F - 0.1F;
    Random random(seed + 1);
    for (auto& value : map.valid.values)
        value = random.uniform() < 0.8 ? 1 : 0;
    std::copy_n(std::array{0.0F, 1.0F, 1.0F, 0.0F}.begin(), 4, map.uv.values.begin());
    map.valid.values[0] = map.valid.values[1] = 1;
    return map;
}

/// Texels that a lookup at (u, v) reads, and their weights, in double precision: every texel is tried.
inline std::map<std::int64_t, double> slow_weights(double u, double v, int size, TexelGrid grid = TexelGrid::centers)
{
    const auto texels = [&](double w) { return grid == TexelGrid::centers ? w * size - 0.5 : w * (size - 1); };
    const double x = std::clamp(texels(u), 0.0, size - 1.0);
    const double y = std::clamp(texels(1 - v), 0.0, size - 1.0);
    std::map<std::int64_t, double> weights;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
        {
            const double w = std::max(0.0, 1 - std::abs(x - column)) * std::max(0.0, 1 - std::abs(y - row));
            if (w > 0)
                weights[static_cast<std::int64_t>(row) * size + column] = w;
        }
    return weights;
}

}  // namespace texture_samples
