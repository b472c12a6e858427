#include "pattern.h"

#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace pattern
{
namespace
{

using fresco::noise::hash;
using fresco::noise::smooth_step;
using fresco::noise::unit;

/// [-1, 1)
constexpr float signed_unit(std::uint32_t a, std::uint32_t b)
{
    return 2 * unit(a, b) - 1;
}

/// Smooth noise in [0, 1] with features of size 1.
inline float value_noise(float x, float y, std::uint32_t seed)
{
    const float fx = std::floor(x), fy = std::floor(y);
    const auto corner = [&](float cx, float cy)
    {
        return unit(static_cast<std::uint32_t>(static_cast<int>(cx)) * 0x8da6b343U +
                        static_cast<std::uint32_t>(static_cast<int>(cy)) * 0xd8163841U,
                    seed);
    };
    const float tx = smooth_step(0, 1, x - fx), ty = smooth_step(0, 1, y - fy);
    const float lower = corner(fx, fy) * (1 - tx) + corner(fx + 1, fy) * tx;
    const float upper = corner(fx, fy + 1) * (1 - tx) + corner(fx + 1, fy + 1) * tx;
    return lower * (1 - ty) + upper * ty;
}

/// Four octaves, [0, 1].
inline float fractal_noise(float x, float y, std::uint32_t seed)
{
    float sum = 0, amplitude = 0.5f;
    for (std::uint32_t octave = 0; octave < 4; ++octave)
    {
        sum += amplitude * value_noise(x, y, seed + octave);
        x *= 2.03f;
        y *= 2.03f;
        amplitude *= 0.5f;
    }
    return sum / 0.9375f;
}

constexpr int hills = 3;
constexpr float bands = 9;

Vec3f mix(Vec3f a, Vec3f b, float t)
{
    return a + (b - a) * std::clamp(t, 0.0f, 1.0f);
}

float fraction(float x)
{
    return x - std::floor(x);
}

}  // namespace

Palette palette_named(std::string_view name)
{
    if (name == "night")
        return {
            {0.05f, 0.09f, 0.30f}, {0.13f, 0.33f, 0.66f}, {0.60f, 0.80f, 0.88f}, {0.99f, 0.86f, 0.32f}, {0.93f, 0.50f, 0.10f}};
    if (name == "meadow")
        return {
            {0.06f, 0.22f, 0.14f}, {0.22f, 0.50f, 0.20f}, {0.74f, 0.82f, 0.40f}, {0.98f, 0.93f, 0.70f}, {0.84f, 0.16f, 0.12f}};
    if (name == "ember")
        return {
            {0.24f, 0.04f, 0.10f}, {0.70f, 0.15f, 0.10f}, {0.95f, 0.50f, 0.14f}, {1.00f, 0.88f, 0.46f}, {0.08f, 0.46f, 0.48f}};
    if (name == "sea")
        return {
            {0.03f, 0.16f, 0.28f}, {0.06f, 0.42f, 0.50f}, {0.50f, 0.80f, 0.76f}, {0.97f, 0.96f, 0.88f}, {0.90f, 0.66f, 0.34f}};
    throw std::invalid_argument("palette " + std::string(name));
}

SwirlingSky::SwirlingSky(const Palette& palette, std::uint32_t seed) : palette_(palette), seed_(seed)
{
    // Two large whirls side by side, small ones scattered around them.
    const std::array<Vec2f, 9> places{Vec2f{0.30f, 0.36f}, {0.70f, 0.30f}, {0.10f, 0.12f}, {0.50f, 0.08f}, {0.90f, 0.10f},
                                      {0.52f, 0.52f},      {0.08f, 0.58f}, {0.92f, 0.54f}, {0.28f, 0.64f}};
    for (std::size_t i = 0; i < places.size(); ++i)
    {
        const auto n = static_cast<std::uint32_t>(i);
        const bool large = i < 2;
        whirls_.push_back({places[i] + Vec2f{0.05f * signed_unit(seed, 3 * n), 0.05f * signed_unit(seed, 3 * n + 1)},
                           large ? 0.15f + 0.04f * unit(seed, 3 * n + 2) : 0.05f + 0.04f * unit(seed, 3 * n + 2),
                           unit(seed, 90 + n) < 0.5f ? -1.0f : 1.0f, large ? 0.75f : 1.0f});
    }
}

float SwirlingSky::hill_line(float x, int hill) const
{
    const auto h = static_cast<float>(hill);
    return 0.70f + 0.10f * h + 0.15f * (value_noise(x * 2.4f + 5 * h, 0.5f, seed_ + 40) - 0.5f) +
           0.04f * (value_noise(x * 8 + h, 1.5f, seed_ + 41) - 0.5f);
}

int SwirlingSky::hill_at(Vec2f at) const
{
    int found = -1;
    for (int hill = 0; hill < hills; ++hill)
        if (at.y > hill_line(at.x, hill))
            found = hill;
    return found;
}

Vec3f SwirlingSky::color(Vec2f at) const
{
    const float streak = fractal_noise(at.x * 7, at.y * 7, seed_ + 11);
    if (const int hill = hill_at(at); hill >= 0)
    {
        const auto h = static_cast<float>(hill);
        const Vec3f ground = mix(mix(palette_.middle, palette_.glow, 0.30f), palette_.deep, 0.30f * h + 0.25f * streak);
        const bool lit = streak > 0.60f;
        const float edge = at.y - hill_line(at.x, hill);
        return edge < 0.014f ? palette_.deep * 0.6f : lit ? mix(ground, h < 1 ? palette_.light : palette_.accent, 0.65f) : ground;
    }
    Vec3f sky = mix(palette_.deep, palette_.middle, 0.25f + 1.1f * streak);
    sky = mix(sky, palette_.light, smooth_step(0.55f, 0.78f, fractal_noise(at.x * 3 + 9, at.y * 9, seed_ + 5)) * 0.85f);
    for (const auto& whirl : whirls_)
    {
        const float distance = length(at - whirl.center) / whirl.radius;
        if (distance > 2.2f)
            continue;
        const float rings = 0.5f + 0.5f * std::cos(distance * 11 + 4 * streak);
        const float near = 1 - smooth_step(0.5f, 2.1f, distance);
        sky = mix(sky, mix(palette_.light, palette_.glow, near * whirl.brightness), near * rings * 0.95f);
        sky = mix(mix(palette_.glow, palette_.accent, distance > 0.26f ? 0.6f : 0.0f), sky, smooth_step(0.34f, 0.5f, distance));
    }
    return sky;
}

float SwirlingSky::direction(Vec2f at) const
{
    if (const int hill = hill_at(at); hill >= 0)
    {
        const float slope = (hill_line(at.x + 0.02f, hill) - hill_line(at.x - 0.02f, hill)) / 0.04f;
        return std::atan(slope) + 0.5f * (fractal_noise(at.x * 4, at.y * 6, seed_ + 14) - 0.5f);
    }
    Vec2f flow{0.55f, 0.5f * (fractal_noise(at.x * 2.5f, at.y * 2.5f, seed_ + 17) - 0.5f)};
    for (const auto& whirl : whirls_)
    {
        const Vec2f away = at - whirl.center;
        const float squared = dot(away, away) / (whirl.radius * whirl.radius);
        const float strength = 3.2f * whirl.turn * std::exp(-0.5f * squared) / whirl.radius;
        flow = flow + Vec2f{-away.y, away.x} * strength;
    }
    return std::atan2(flow.y, flow.x);
}

float RollingWaves::phase(Vec2f at) const
{
    const float swell = 0.060f * std::sin(at.x * 9 + 5 * at.y + 6 * unit(seed_, 1u)) +
                        0.035f * std::sin(at.x * 19 - 8 * at.y + 6 * unit(seed_, 2u));
    const float bend = 0.30f * (value_noise(at.x * 2.2f, at.y * 2.2f, seed_ + 3) - 0.5f);
    return (at.y + swell + bend) * bands;
}

Vec3f RollingWaves::color(Vec2f at) const
{
    const float p = phase(at), within = fraction(p);
    const auto band = static_cast<std::uint32_t>(static_cast<int>(std::floor(p)) + 64);
    const std::array<Vec3f, 5> tones{palette_.middle, palette_.deep, mix(palette_.middle, palette_.light, 0.55f), palette_.accent,
                                     mix(palette_.deep, palette_.middle, 0.6f)};
    const Vec3f body = tones[hash(seed_, band) % tones.size()];
    const float streak = fractal_noise(at.x * 5, p * 4, seed_ + 8);
    Vec3f color = mix(body, palette_.light, smooth_step(0.25f, 0.0f, within) * 0.8f + 0.5f * (streak - 0.45f));
    color = mix(color, palette_.deep, smooth_step(0.55f, 1.0f, within) * 0.55f);
    const float foam = fractal_noise(at.x * 16, p * 3, seed_ + 9);
    if (within < 0.20f * foam + 0.06f && hash(seed_ + 1, band) % 3 != 0)
        color = palette_.glow;
    return within > 0.945f ? palette_.deep * 0.55f : color;
}

float RollingWaves::direction(Vec2f at) const
{
    const float step = 0.004f;
    const float dx = phase(at + Vec2f{step, 0}) - phase(at - Vec2f{step, 0});
    const float dy = phase(at + Vec2f{0, step}) - phase(at - Vec2f{0, step});
    return std::atan2(-dx, dy);
}

namespace
{

constexpr int oversampling = 2;
constexpr std::array<float, 4> layer_widths{1.0f, 0.62f, 0.40f, 0.26f};
/// Distance of strokes in widths: the first layer covers the canvas, finer ones leave it showing.
constexpr std::array<float, 4> layer_spacing{0.55f, 0.75f, 1.0f, 1.35f};
constexpr float least_width_px = 3;
constexpr float step_px = 0.75f;
constexpr int steps_per_turn = 8;
constexpr std::size_t strokes_per_check = 64;

struct Canvas
{
    explicit Canvas(int size) : color(size, size, 3), height(size, size) {}
    fresco::Raster<float> color;
    fresco::Raster<float> height;
};

struct Stroke
{
    Vec2f start;  ///< Pixels.
    float width;
    float length;
    Vec3f color;
    std::uint32_t seed;
};

/// One row of bristles across the path.
void press(Canvas& canvas, const Stroke& stroke, Vec2f at, Vec2f along, float share)
{
    const int size = canvas.color.width;
    const Vec2f across{-along.y, along.x};
    // Tapered ends; bristles run dry toward the end.
    const float half = 0.5f * stroke.width * std::min(1.0f, std::min(0.35f + 4.5f * share, 0.25f + 3.0f * (1 - share)));
    const float dryness = 0.12f + 0.55f * share * share;
    for (float s = -half; s <= half; s += step_px)
    {
        const float side = s / (0.5f * stroke.width);
        const float bristle = value_noise(side * 7 + 11, share * 2.5f, stroke.seed);
        const float drag = value_noise(side * 16 + 31, share * 9, stroke.seed + 1);
        if (drag < dryness * (0.35f + 0.65f * std::abs(side)))
            continue;
        const Vec2f p = at + across * s;
        const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
        if (x < 0 || y < 0 || x >= size || y >= size)
            continue;
        const float tone = 0.82f + 0.36f * bristle;
        canvas.color.at(x, y, 0) = stroke.color.x * tone;
        canvas.color.at(x, y, 1) = stroke.color.y * tone;
        canvas.color.at(x, y, 2) = stroke.color.z * tone;
        // Paint is pushed to the sides of the stroke.
        canvas.height.at(x, y) = 0.35f * canvas.height.at(x, y) + stroke.width * (0.06f * side * side + 0.10f * bristle);
    }
}

void draw(Canvas& canvas, const Motif& motif, const Stroke& stroke)
{
    const auto size = static_cast<float>(canvas.color.width);
    Vec2f at = stroke.start;
    const float first = motif.direction(at * (1 / size));
    // Half of the way back, so that the stroke's middle lies at its start.
    at = at - Vec2f{std::cos(first), std::sin(first)} * (0.3f * stroke.length);
    Vec2f along;
    const int steps = static_cast<int>(stroke.length / step_px);
    for (int i = 0; i < steps; ++i)
    {
        if (i % steps_per_turn == 0)
        {
            const float angle = motif.direction(at * (1 / size));
            along = {std::cos(angle), std::sin(angle)};
        }
        press(canvas, stroke, at, along, static_cast<float>(i) / static_cast<float>(steps));
        at = at + along * step_px;
    }
}

/// Strokes of one layer on a jittered grid, in random order.
std::vector<Stroke> layer_strokes(const Motif& motif, int size, float width, float length, float spacing, std::uint32_t seed)
{
    const int count = std::max(1, static_cast<int>(static_cast<float>(size) / (spacing * width)));
    const float cell = static_cast<float>(size) / static_cast<float>(count);
    std::vector<Stroke> strokes;
    for (int row = -1; row <= count; ++row)
        for (int column = -1; column <= count; ++column)
        {
            const auto id = hash(seed, static_cast<std::uint32_t>((row + 1) * (count + 2) + column + 1));
            const Vec2f at{(static_cast<float>(column) + unit(id, 1u)) * cell, (static_cast<float>(row) + unit(id, 2u)) * cell};
            const Vec3f color = motif.color(at * (1 / static_cast<float>(size)));
            const float tone = 1 + 0.16f * signed_unit(id, 3u);
            const auto vary = [&](float v, std::uint32_t n)
            { return std::clamp(v * tone + 0.05f * signed_unit(id, n), 0.0f, 1.0f); };
            strokes.push_back({at,
                               width * (0.8f + 0.4f * unit(id, 4u)),
                               length * (0.7f + 0.6f * unit(id, 5u)),
                               {vary(color.x, 6), vary(color.y, 7), vary(color.z, 8)},
                               id});
        }
    std::sort(strokes.begin(), strokes.end(), [](const Stroke& a, const Stroke& b) { return a.seed < b.seed; });
    return strokes;
}

/// Colors under a light from the upper left that grazes the paint.
fresco::Raster<float> lit(const Canvas& canvas)
{
    const int size = canvas.color.width;
    fresco::Raster<float> picture(size, size, 3);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const float slope = canvas.height.at(std::max(x - 1, 0), std::max(y - 1, 0)) -
                                canvas.height.at(std::min(x + 1, size - 1), std::min(y + 1, size - 1));
            const float light = 1 - std::clamp(0.14f * slope, -0.24f, 0.28f);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = std::clamp(canvas.color.at(x, y, c) * light, 0.0f, 1.0f);
        }
    return picture;
}

}  // namespace

fresco::Raster<std::uint8_t> paint(const Motif& motif, const BrushOptions& options, fresco::Progress& progress)
{
    const int size = options.size_px * oversampling;
    Canvas canvas(size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const Vec3f ground = motif.color({(static_cast<float>(x) + 0.5f) / static_cast<float>(size),
                                              (static_cast<float>(y) + 0.5f) / static_cast<float>(size)});
            canvas.color.at(x, y, 0) = ground.x * 0.95f;
            canvas.color.at(x, y, 1) = ground.y * 0.95f;
            canvas.color.at(x, y, 2) = ground.z * 0.95f;
        }
    for (std::size_t layer = 0; layer < layer_widths.size(); ++layer)
    {
        const float width = std::max(least_width_px, options.stroke_share * layer_widths[layer] * static_cast<float>(size));
        const auto strokes = layer_strokes(motif, size, width, width * options.stroke_length, layer_spacing[layer],
                                           hash(options.seed, static_cast<std::uint32_t>(layer)));
        for (std::size_t i = 0; i < strokes.size(); ++i)
        {
            if (i % strokes_per_check == 0)
                progress.check_canceled();
            draw(canvas, motif, strokes[i]);
        }
        progress.progress(static_cast<double>(layer + 1), static_cast<double>(layer_widths.size()), "layers");
    }
    const auto small = fresco::resized(lit(canvas), options.size_px, options.size_px);
    fresco::Raster<std::uint8_t> picture(options.size_px, options.size_px, 3);
    std::transform(small.values.begin(), small.values.end(), picture.values.begin(),
                   [](float v) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); });
    return picture;
}

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

/// `count` x `count` of them.
std::vector<Stone> laid_stones(const Motif& motif, int count, std::uint32_t seed)
{
    std::vector<Stone> stones;
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
            stones.push_back({place,
                              {std::cos(angle), std::sin(angle)},
                              motif.color(place) * tone,
                              {signed_unit(id, 4u), signed_unit(id, 5u)},
                              id});
        }
    return stones;
}

/// Between a circle's and a square's, turned with the stone: cells become rounded squares.
float distance(const Stone& stone, Vec2f at)
{
    const Vec2f d = at - stone.place;
    const float u = dot(d, stone.along), v = fresco::cross(stone.along, d);
    const float u2 = u * u, v2 = v * v * 1.2f;
    return std::sqrt(std::sqrt(u2 * u2 + v2 * v2));
}

/// Of `count` x `count` stones.
Vec3f mosaic_color(const std::vector<Stone>& stones, int count, Vec2f at)
{
    const auto scale = static_cast<float>(count);
    const int column = static_cast<int>(at.x * scale), row = static_cast<int>(at.y * scale);
    float nearest = 1e9f, second = 1e9f;
    const Stone* stone = nullptr;
    for (int r = std::max(0, row - 2); r <= std::min(count - 1, row + 2); ++r)
        for (int c = std::max(0, column - 2); c <= std::min(count - 1, column + 2); ++c)
        {
            const Stone& candidate = stones[static_cast<std::size_t>(r * count + c)];
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

}  // namespace

fresco::Raster<std::uint8_t> lay_mosaic(const Motif& motif, int size_px, int stones, std::uint32_t seed,
                                        fresco::Progress& progress)
{
    const std::vector<Stone> laid = laid_stones(motif, stones, seed);
    fresco::Raster<std::uint8_t> picture(size_px, size_px, 3);
    const float pixel = 1 / static_cast<float>(size_px);
    fresco::parallel_items(
        size_px, 16, progress,
        [&](int y)
        {
            for (int x = 0; x < size_px; ++x)
            {
                Vec3f sum;
                for (int i = 0; i < samples * samples; ++i)
                    sum += mosaic_color(laid, stones,
                                        {(static_cast<float>(x) + (static_cast<float>(i % samples) + 0.5f) / samples) * pixel,
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
