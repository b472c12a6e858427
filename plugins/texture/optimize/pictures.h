#pragma once

/// \file Pictures on their way into the optimization, without tensors: stored values and displayed colors, the sizes of the
/// style picture, noise, textures as views show them, and views' colors gathered into texels.

#include "levels.h"

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fresco::optimize
{

/// Meaning of the texture's numbers.
enum class Values
{
    display,  ///< RGB in [0,1].
    network   ///< BGR in 0..255 minus (103.939, 116.779, 123.68).
};

/// Stored values to pictures, which are displayed RGB, clamped to [0,1], and back.
class ValueSpace
{
  public:
    /// With `clamped` false pictures are shown beyond [0,1] too, and all gradients pass.
    explicit ValueSpace(Values values, bool clamped = true) : network_(values == Values::network), clamped_(clamped) {}

    /// The range of stored values whose every channel may be displayed; each layer's in the authors' code.
    std::pair<double, double> stored_range() const;

    /// Displayed RGB (3 channels) to stored values, in place.
    void store(RasterF& picture) const;

    bool is_network() const { return network_; }
    bool is_clamped() const { return clamped_; }
    /// Displayed channel c shows (stored + offset) * scale of its stored plane, which are in turned order for a network.
    float offset(std::size_t channel) const;
    float scale() const { return network_ ? 1.0F / 255 : 1.0F; }

  private:
    bool network_;
    bool clamped_;
};

/// The two sizes of the style picture, RGB in [0,1] (StyleMesh, section 3.3).
struct StyleSizes
{
    RasterF fine;
    RasterF coarse;
};

/// Gray is spread over three channels. A longer side over 2048 px is first reduced to 2048; `fine`
/// has a shorter side of exactly 256 px, never enlarged (then `message` says so); `coarse` is four times as large, at most the
/// picture. Released: where a side is over 2048 px, the shorter becomes 2048, which may enlarge; then `fine` has a shorter side
/// of 256 px, enlarged too, and `coarse` is the third of these: 256 px, the halvings that are no smaller, ascending (256 px again
/// where one is), the picture. Both without antialiasing. Throws Error for a side below 64 px, another number of channels than
/// 1, 3 or 4, and transparent pixels.
StyleSizes style_sizes(const Raster8& picture, Protocol protocol, const std::function<void(const std::string&)>& message);

/// S x S x 3 of colored noise: the sum of five octaves with cells of 4 to 64 texels, each interpolated between random corners,
/// about `mean` with `deviation` in each channel on its own; clamped to [0,1]. The same bytes on every machine, for any number of
/// threads.
RasterF noise_picture(int size_px, Vec3d mean, Vec3d deviation, std::uint64_t seed, int threads);

/// The sum of the layers, clamped to [0,1]. \pre values: display
RasterF displayed(const Texture& texture);

/// A texture as views without a picture show it.
class ShownTexture
{
  public:
    /// As displayed. Keeps a copy at full, half, quarter … size.
    explicit ShownTexture(const Texture& texture);

    /// RGB of the map's size; black where it is not valid. Each pixel looks up the size of the texture at which its neighbors
    /// are about a texel away, bilinearly: fine detail does not flicker where a view is coarser than the texture.
    Raster8 shown(const UvMap& map) const;

  private:
    std::vector<RasterF> sizes_;
};

/// Gathers what views show into texels: the transpose of the bilinear lookup, normalized. Views are added one by one, in order.
class TexelGatherer
{
  public:
    /// Without `with_colors` only mark() and seen() work, and no sums are kept.
    TexelGatherer(int size_px, bool with_colors);

    /// Marks the texels that the map's valid pixels touch.
    void mark(const UvMap& map);
    /// Marks them and adds the pixels' colors (`camera`: RGB in [0,1] of the map's size), each with its bilinear weight times
    /// cos α / depth: a near and frontal view says more about a texel than a far and oblique one.
    void add(const UvMap& map, const RasterF& camera);

    /// S x S, 1 = touched.
    const Raster8& seen() const { return seen_; }
    /// S x S x 3: the weighted mean of the colors; `covered` (S x S) becomes 1 where there is one, and elsewhere the color is
    /// 0. Frees the sums: call it once.
    RasterF take_colors(Raster8& covered);

  private:
    template <class Visit>
    void each_texel(const UvMap& map, const Visit& visit);

    int size_;
    Raster8 seen_;
    RasterF sums_;  ///< S x S x 4: weighted colors and the weight.
};

}  // namespace fresco::optimize
