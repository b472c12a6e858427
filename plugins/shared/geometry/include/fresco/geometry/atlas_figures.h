#pragma once

#include <fresco/mesh.h>
#include <fresco/run_context.h>

#include <cstddef>
#include <cstdint>
#include <vector>

/// \file Quality figures of an atlas, computed from the mesh's texcoords, whatever made them.

namespace fresco::geometry
{

struct AtlasFigures
{
    std::size_t charts = 0;        ///< Sets of faces that are connected through edges without a seam.
    double used_share = 0;         ///< Share of the square: the area of all faces in it. Overlapping faces count each.
    double texels_per_cm = 0;      ///< Root of all texels of the faces over all their area.
    double stretch_l2 = 0;         ///< Root mean square of the singular values, see below; 1 = isometric, at least 1.
    double stretch_linf = 0;       ///< The largest singular value: the place where a texel is longest, over its mean size.
    double density_variation = 0;  ///< Standard deviation of texels per length over its mean, weighted by area; 0 = one scale.
    double squeezed_share = 0;   ///< Share of the area in faces with less than a quarter of the texels that their area is worth.
    std::size_t lost_faces = 0;  ///< Have area, but less than a millionth of the texels they are worth; not in the stretches.
    double seam_length_m = 0;    ///< Edges between two faces that the atlas cuts.
    double seam_length_share = 0;     ///< Share of the length of all edges between two faces.
    std::size_t outside_corners = 0;  ///< Texcoords that are not in [0,1].
};

/// Measures a mesh with texcoords, for a texture of size_px². The stretches are the L² and L∞ norms of Sander et al., "Texture
/// mapping progressive meshes", SIGGRAPH 2001, section 3, times the root of the atlas's area over the surface's: both 1 when
/// every face keeps its shape and all are of one scale.
/// \pre Mesh and texcoords have an area.
AtlasFigures atlas_figures(const Mesh& mesh, int size_px);

/// Enters them into a stage's report, each under its name.
void report_atlas(RunContext& run, const AtlasFigures& figures);

}  // namespace fresco::geometry
