#include "painter.h"

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{
constexpr int rounds = 30;

struct Sample
{
    Vec2f uv;
    std::array<double, 3> color;
};

std::vector<Sample> samples_of(const UvMaps& maps, const std::vector<Camera>& cameras, int size_px, Mistake mistake)
{
    std::vector<Sample> samples;
    for (std::size_t view = 0; view < maps.views.size(); ++view)
    {
        const UvMap map = maps.load_map(view, 0);
        Camera camera = cameras[view];
        camera.intrinsics = camera.intrinsics.scaled_to(map.uv.width, map.uv.height);
        for (int y = 0; y < map.uv.height; ++y)
            for (int x = 0; x < map.uv.width; ++x)
            {
                if (!map.valid.at(x, y))
                    continue;
                const double px = mistake == Mistake::mirrored_axis ? map.uv.width - (x + 0.5) : x + 0.5;
                const Vec3d point = camera.world_from_camera.translation + camera.ray(px, y + 0.5) * double{map.depth.at(x, y)};
                Vec2f uv{map.uv.at(x, y, 0), map.uv.at(x, y, 1)};
                if (mistake == Mistake::flipped_v)
                    uv.y = 1 - uv.y;
                if (mistake == Mistake::half_texel)
                    uv = uv + Vec2f{0.5F, 0.5F} * (1.0F / static_cast<float>(size_px));
                samples.push_back({uv, paint_at(point.x, point.y, point.z)});
            }
    }
    return samples;
}

/// The four texels and shares of a bilinear lookup.
struct Taps
{
    std::array<std::size_t, 4> texel;
    std::array<float, 4> share;
};

Taps taps_of(Vec2f uv, int size)
{
    const float x = std::clamp(uv.x * static_cast<float>(size) - 0.5F, 0.0F, static_cast<float>(size - 1));
    const float y = std::clamp((1 - uv.y) * static_cast<float>(size) - 0.5F, 0.0F, static_cast<float>(size - 1));
    const auto x0 = static_cast<std::size_t>(x);
    const auto y0 = static_cast<std::size_t>(y);
    const auto s = static_cast<std::size_t>(size);
    const std::size_t x1 = std::min(x0 + 1, s - 1);
    const std::size_t y1 = std::min(y0 + 1, s - 1);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    return {{y0 * s + x0, y0 * s + x1, y1 * s + x0, y1 * s + x1}, {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}
}  // namespace

std::array<double, 3> paint_at(double x, double y, double z)
{
    return {0.5 + 0.4 * std::sin(1.9 * x + 0.7 * y), 0.5 + 0.4 * std::sin(1.6 * y + 1.1 * z + 1),
            0.5 + 0.4 * std::sin(1.8 * z - 0.9 * x + 2)};
}

Texture painted(const UvMaps& maps, const std::vector<Camera>& cameras, int size_px, Mistake mistake)
{
    Texture texture;
    texture.layers = {RasterF(size_px, size_px, 3, 0.5F), RasterF(size_px / 2, size_px / 2, 3)};
    for (std::size_t i = 0; i < texture.layers[1].values.size(); ++i)
        texture.layers[1].values[i] = 0.05F * std::sin(static_cast<float>(i) * 0.01F);
    texture.seen = Raster8(size_px, size_px);

    const std::vector<Sample> samples = samples_of(maps, cameras, size_px, mistake);
    RasterF& fine = texture.layers[0];
    std::vector<float> difference(fine.values.size());
    std::vector<float> weight(texture.seen.values.size());
    for (int round = 0; round < rounds; ++round)
    {
        std::fill(difference.begin(), difference.end(), 0.0F);
        std::fill(weight.begin(), weight.end(), 0.0F);
        for (const Sample& sample : samples)
        {
            std::array<float, 3> low{};
            std::array<float, 3> high{};
            sample_bilinear(texture.layers[0], sample.uv.x, sample.uv.y, low.data());
            sample_bilinear(texture.layers[1], sample.uv.x, sample.uv.y, high.data());
            const Taps taps = taps_of(sample.uv, size_px);
            for (std::size_t t = 0; t < 4; ++t)
            {
                weight[taps.texel[t]] += taps.share[t];
                for (std::size_t c = 0; c < 3; ++c)
                    difference[3 * taps.texel[t] + c] += taps.share[t] * (static_cast<float>(sample.color[c]) - low[c] - high[c]);
            }
        }
        for (std::size_t texel = 0; texel < weight.size(); ++texel)
            if (weight[texel] > 0)
            {
                texture.seen.values[texel] = 1;
                for (std::size_t c = 0; c < 3; ++c)
                    fine.values[3 * texel + c] += difference[3 * texel + c] / weight[texel];
            }
    }
    return texture;
}
