#pragma once

#include <fresco/geometry/packing.h>

/// \file Shared by atlas stages, apart from charts and packing.

namespace fresco::geometry
{

/// A copy of the mesh with texcoords and charts, numbered without gaps by first face.
Mesh with_atlas(const Mesh& mesh, const FlatCharts& flat, const Packing& packing);

/// The largest angle between a plainly projected face with area and the direction of projection; 0 if there is none.
double largest_angle_deg(const Surface& surface, const FlatCharts& flat);

/// The size of a texel (meters) when 70 % of the texture are used.
double expected_texel_m(const Surface& surface, int size_px);

}  // namespace fresco::geometry
