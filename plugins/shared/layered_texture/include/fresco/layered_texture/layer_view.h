#pragma once

#include <fresco/uv_maps.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file One uv map looked up in one square layer of 3-channel texels, both ways: texels to pixels, and pixel gradients back to
/// texels.

namespace fresco
{

/// Pixels of a uv map that are valid, in row-major order, with their uv.
struct ValidPixels
{
    int width = 0;
    int height = 0;
    std::vector<std::int32_t> pixels;  ///< y * width + x
    std::vector<float> uv;             ///< 2 per pixel
};
/// Throws Error if a valid pixel's uv is not finite.
ValidPixels valid_pixels(const UvMap& map);

/// Positions of a layer's texels in the unit square.
enum class TexelGrid
{
    centers,  ///< Texel i of S at (i + 0.5) / S; clamped at the borders.
    corners   ///< Texel i of S at i / (S - 1): the outermost lie on the border ("align corners").
};

/// The bilinear lookups of V valid pixels in a layer of S x S texels, S >= 2: row 0 at v = 1, with TexelGrid::centers rounded
/// exactly as fresco::sample_bilinear. Immutable after construction; any thread.
class LayerView
{
  public:
    LayerView(const ValidPixels& pixels, int size, TexelGrid grid = TexelGrid::centers);

    /// Adds to `out` (3 per valid pixel) the lookups in `texels` (3 S², row-major) for valid pixels [begin, end).
    void add_lookup(const float* texels, std::size_t begin, std::size_t end, float* out) const;

    /// Texels with at least one weight above zero, ascending.
    std::span<const std::int64_t> texels() const { return texels_; }
    /// For touched texels [begin, end): `out` (3 per texel) = sum over the lookups of weight times `gradient` (3 per valid
    /// pixel), in the order of the pixels. The work is that of the pixels, whatever the size of the layer.
    void gather(const float* gradient, std::size_t begin, std::size_t end, float* out) const;

  private:
    int size_;
    std::vector<std::int32_t> base_;      ///< Per pixel: its upper left texel, at most row and column S - 2.
    std::vector<float> fraction_;         ///< Per pixel: the shares of the right and of the lower texels.
    std::vector<std::int64_t> texels_;    ///< Touched.
    std::vector<std::uint32_t> offsets_;  ///< Per touched texel, and one more: where its lookups begin in lookups_.
    std::vector<std::uint32_t> lookups_;  ///< 4 * pixel + corner.

    float weight(std::uint32_t lookup) const;
};

}  // namespace fresco
