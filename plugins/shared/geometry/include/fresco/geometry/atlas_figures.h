#pragma once

#include <fresco/mesh.h>
#include <fresco/run_context.h>

/// \file Quality figures of an atlas, computed from the mesh's texcoords, whatever made them.

namespace fresco::geometry
{

/// Measures a mesh with texcoords, for a texture of size_px², and reports:
/// - charts: sets of faces that are connected through edges without a seam
/// - used_share: of the square, the area of all faces in it; overlapping faces count each
/// - texels_per_cm: root of all texels of the faces over all their area
/// - stretch_l2, stretch_linf: root mean square of the singular values, and the largest: the norms of Sander et al., "Texture
///   mapping progressive meshes", SIGGRAPH 2001, section 3, times the root of the atlas's area over the surface's: both 1 when
///   every face keeps its shape and all are of one scale, at least 1
/// - density_variation: standard deviation of texels per length over its mean, weighted by area; 0 = one scale
/// - squeezed_share: of the area, in faces with less than a quarter of the texels that their area is worth
/// - lost_faces: have area, but less than a millionth of the texels they are worth; not in the stretches
/// - seam_length_m, seam_length_share: edges between two faces that the atlas cuts, and their share of the length of all
/// - outside_corners: texcoords that are not in [0,1]
/// \pre Mesh and texcoords have an area.
void report_atlas(RunContext& run, const Mesh& mesh, int size_px);

}  // namespace fresco::geometry
