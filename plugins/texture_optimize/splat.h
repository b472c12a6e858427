#pragma once

#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <vector>

namespace fresco::optimize
{

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
