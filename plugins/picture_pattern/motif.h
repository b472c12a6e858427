#pragma once

#include <fresco/math.h>

#include <cstdint>
#include <string_view>
#include <vector>

namespace pattern
{

using fresco::Vec2f;
using fresco::Vec3f;

/// Display colors (sRGB, 0..1) of a picture.
struct Palette
{
    Vec3f deep;
    Vec3f middle;
    Vec3f light;
    Vec3f glow;
    Vec3f accent;
};

/// "night", "meadow", "ember" or "sea". Throws std::invalid_argument for another name.
Palette palette_named(std::string_view name);

/// What is painted: a color and a direction of the brush at each place. Places are x to the right and y down, 0..1.
class Motif
{
  public:
    virtual ~Motif() = default;
    virtual Vec3f color(Vec2f at) const = 0;
    /// Radians, from x to y.
    virtual float direction(Vec2f at) const = 0;
};

/// Whirls of light in a sky over hills.
class SwirlingSky final : public Motif
{
  public:
    SwirlingSky(const Palette& palette, std::uint32_t seed);
    Vec3f color(Vec2f at) const override;
    float direction(Vec2f at) const override;

  private:
    struct Whirl
    {
        Vec2f center;
        float radius;
        float turn;  ///< +1 or -1.
        float brightness;
    };
    float hill_line(float x, int hill) const;
    int hill_at(Vec2f at) const;

    Palette palette_;
    std::uint32_t seed_;
    std::vector<Whirl> whirls_;
};

/// Long rolling waves in outlined bands, with foam on their crests.
class RollingWaves final : public Motif
{
  public:
    RollingWaves(const Palette& palette, std::uint32_t seed) : palette_(palette), seed_(seed) {}
    Vec3f color(Vec2f at) const override;
    float direction(Vec2f at) const override;

  private:
    float phase(Vec2f at) const;

    Palette palette_;
    std::uint32_t seed_;
};

}  // namespace pattern
