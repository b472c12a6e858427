#pragma once

#include <fresco/image.h>
#include <fresco/texturing/texel_faces.h>

#include <cstdint>
#include <vector>

/// A picture of a texture and where it is known.
struct KnownPicture
{
    fresco::RasterF rgb;       ///< S x S x 3
    fresco::Raster8 is_known;  ///< S x S
};

/// Rule for a region's texels: photo + strength (painted - photo).
struct RegionRule
{
    const KnownPicture* painted = nullptr;  ///< nullptr: the photo.
    float strength = 1;
};

/// For each texel the region that it belongs to: that of its face, and beside a chart that of the chart's nearest texel, since
/// bilinear lookups at the chart's border reach it; no_region elsewhere.
inline constexpr std::uint32_t no_region = 0xffffffffU;
std::vector<std::uint32_t> regions_of_texels(const fresco::texturing::TexelFaces& faces,
                                             const std::vector<std::uint16_t>& label_of_face);

/// The photo with each region's texels by its rule. Where the strength is 0 or 1, texels are those of one picture, bit for bit; a
/// mixture is clamped to [0,1] and known where both pictures are. Texels without a region are the photo's, and not known. All
/// pictures have one size.
KnownPicture composed(const KnownPicture& photo, const std::vector<std::uint32_t>& region_of_texel,
                      const std::vector<RegionRule>& rules);
