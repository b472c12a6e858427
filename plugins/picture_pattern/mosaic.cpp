#include "mosaic.h"

#include "noise.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>

namespace pattern
{

namespace
{

constexpr int samples = 2;

struct Stone
{
    Vec2f place;  ///< 0..1
    Vec2f along;
    Vec3f color;
    Vec2f tilt;
    std::uint32_t seed;
};

class Stones
{
  public:
    Stones(const Motif& motif, int count, std::uint32_t seed) : count_(count)
    {
        for (int row = 0; row < count; ++row)
            for (int column = 0; column < count; ++column)
            {
                const auto id = hash(seed, static_cast<std::uint32_t>(row * count + column));
                const float shift = row % 2 == 0 ? 0.25f : -0.25f;
                const Vec2f place{(static_cast<float>(column) + 0.5f + shift + 0.18f * signed_unit(id, 1u)) /
                                      static_cast<float>(count),
                                  (static_cast<float>(row) + 0.5f + 0.18f * signed_unit(id, 2u)) / static_cast<float>(count)};
                const float angle = motif.direction(place);
                const float tone = 1 + 0.20f * signed_unit(id, 3u);
                stones_.push_back({place,
                                   {std::cos(angle), std::sin(angle)},
                                   motif.color(place) * tone,
                                   {signed_unit(id, 4u), signed_unit(id, 5u)},
                                   id});
            }
    }

    Vec3f color(Vec2f at) const
    {
        const auto scale = static_cast<float>(count_);
        const int column = static_cast<int>(at.x * scale), row = static_cast<int>(at.y * scale);
        float nearest = 1e9f, second = 1e9f;
        const Stone* stone = nullptr;
        for (int r = std::max(0, row - 2); r <= std::min(count_ - 1, row + 2); ++r)
            for (int c = std::max(0, column - 2); c <= std::min(count_ - 1, column + 2); ++c)
            {
                const Stone& candidate = stones_[static_cast<std::size_t>(r * count_ + c)];
                const float d = distance(candidate, at) * scale;
                if (d < nearest)
                    second = nearest, nearest = d, stone = &candidate;
                else if (d < second)
                    second = d;
            }
        const float gap = second - nearest;
        const Vec2f from = (at - stone->place) * scale;
        const float grain = fractal_noise(from.x * 6 + 50, from.y * 6 + 50, stone->seed);
        const float bevel = smooth_step(0.28f, 0.12f, gap) * (from.x + from.y);
        const float light =
            1 + 0.10f * (stone->tilt.x * from.x + stone->tilt.y * from.y) * 2 - 0.45f * bevel + 0.35f * (grain - 0.5f);
        const Vec3f grout = Vec3f{0.20f, 0.18f, 0.16f} * (0.8f + 0.5f * grain);
        const float joint = smooth_step(0.13f, 0.07f, gap);
        return stone->color * (light * (1 - joint)) + grout * joint;
    }

  private:
    /// Between a circle's and a square's, turned with the stone: cells become rounded squares.
    static float distance(const Stone& stone, Vec2f at)
    {
        const Vec2f d = at - stone.place;
        const float u = dot(d, stone.along), v = fresco::cross(stone.along, d);
        const float u2 = u * u, v2 = v * v * 1.2f;
        return std::sqrt(std::sqrt(u2 * u2 + v2 * v2));
    }

    int count_;
    std::vector<Stone> stones_;
};

}  // namespace

fresco::Raster<std::uint8_t> lay_mosaic(const Motif& motif, int size_px, int stones, std::uint32_t seed,
                                        fresco::Progress& progress)
{
    const Stones laid(motif, stones, seed);
    fresco::Raster<std::uint8_t> picture(size_px, size_px, 3);
    const float pixel = 1 / static_cast<float>(size_px);
    fresco::parallel_for(
        static_cast<std::size_t>(size_px), 16, progress.threads(),
        [&](std::size_t begin, std::size_t end)
        {
            progress.check_canceled();
            for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                for (int x = 0; x < size_px; ++x)
                {
                    Vec3f sum;
                    for (int i = 0; i < samples * samples; ++i)
                        sum += laid.color({(static_cast<float>(x) + (static_cast<float>(i % samples) + 0.5f) / samples) * pixel,
                                           (static_cast<float>(y) + (static_cast<float>(i / samples) + 0.5f) / samples) * pixel});
                    const auto level = [](float v)
                    { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v / (samples * samples), 0.0f, 1.0f))); };
                    picture.at(x, y, 0) = level(sum.x);
                    picture.at(x, y, 1) = level(sum.y);
                    picture.at(x, y, 2) = level(sum.z);
                }
        });
    return picture;
}

}  // namespace pattern
