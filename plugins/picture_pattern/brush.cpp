#include "brush.h"

#include "noise.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace pattern
{

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

}  // namespace pattern
