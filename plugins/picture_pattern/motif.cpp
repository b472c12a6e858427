#include "motif.h"

#include "noise.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace pattern
{

namespace
{

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

}  // namespace pattern
