#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/parallel.h>

#include <cstdint>
#include <string_view>
#include <vector>

/// \file Generates pictures that look painted, so that the demo and the tests need no data: a motif gives colors and directions,
/// and a brush or a mosaic paints it. The stage combines them.

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

/// A subject to paint: a color and a direction of the brush at each place. Places are x to the right and y down, 0..1.
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

struct BrushOptions
{
    int size_px;
    float stroke_share;   ///< Width of the broadest brush as a share of the picture.
    float stroke_length;  ///< Length of a stroke in widths.
    std::uint32_t seed;
};

/// Paints a motif with layers of bristled strokes that follow its direction, broad ones first, and lights the paint from the
/// upper left. After Litwinowicz, "Processing images and video for an impressionist effect" (SIGGRAPH 1997) and Hertzmann,
/// "Painterly rendering with curved brush strokes of multiple sizes" (SIGGRAPH 1998). Square RGB. Single-threaded. Throws
/// Canceled.
fresco::Raster<std::uint8_t> paint(const Motif& motif, const BrushOptions& options, fresco::Progress& progress);

/// Lays a motif in small square stones along its direction, with grout between them and a light from the upper left. After
/// Hausner, "Simulating decorative mosaics" (SIGGRAPH 2001), with jittered places in place of his relaxation.
/// \param stones  stones across the picture
/// Square RGB; the same for any thread count. Throws Canceled.
fresco::Raster<std::uint8_t> lay_mosaic(const Motif& motif, int size_px, int stones, std::uint32_t seed,
                                        fresco::Progress& progress);

}  // namespace pattern
