#pragma once

#include <fresco/mesh.h>

namespace fresco::synthesize
{

/// The side of a texel on the surface, by the area of the charts. The mesh must have texcoords. Throws Error if they or the
/// surface have no area.
double mean_texel_m(const Mesh& mesh, int size_px);

/// Throws Error unless strokes are at least two texels wide, and no wider than the room is long.
void check_stroke_width(const Mesh& mesh, double stroke_m, double texel_m);

}  // namespace fresco::synthesize
