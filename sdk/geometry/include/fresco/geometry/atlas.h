#pragma once

#include <fresco/geometry/packing.h>
#include <fresco/value.h>

/// \file What atlas stages share: packing, filling the mesh, measuring.

namespace fresco::geometry
{

/// Figures of an atlas.
struct AtlasMeasures
{
    std::size_t charts = 0;
    double used_share = 0;         ///< Of the square that faces cover.
    double texels_per_cm = 0;      ///< At size_px; world scale of the charts.
    double seam_length_share = 0;  ///< Of all edge length between two faces: that between two charts.
    double seam_length_m = 0;
    double largest_angle_deg = 0;  ///< Between a projected face with area and the direction of projection.
    double stretch_mean = 0;       ///< Area-weighted mean of area on the surface over area in the atlas, both at world scale.
    double squeezed_share = 0;     ///< Of the area: faces that got less than a quarter of their texels.
};

/// A copy of the mesh with texcoords and charts, numbered without gaps by first face.
Mesh with_atlas(const Mesh& mesh, const FlatCharts& flat, const Packing& packing);

AtlasMeasures measure_atlas(const Surface& surface, const FlatCharts& flat, const Packing& packing);

/// The size of a texel (metres) when 70 % of the texture are used.
double expected_texel_m(const Surface& surface, int size_px);

}  // namespace fresco::geometry
