#pragma once

#include <fresco/mesh.h>

#include <cstddef>

/// \file What an atlas is worth, from the mesh's texcoords alone, whatever made them.

namespace bench
{

struct AtlasFigures
{
    std::size_t charts = 0;    ///< Sets of faces that are connected through edges without a seam.
    double used_share = 0;     ///< Of the square: the area of all faces in it. Overlapping faces count each.
    double texels_per_cm = 0;  ///< Root of all texels of the faces over all their area.
    double stretch_l2 = 0;     ///< Root mean square of the singular values, see below; 1 = isometric, at least 1.
    double density_variation =
        0;  ///< Standard deviation of texels per length over its mean, weighted by area; 0 = the same all over.
    double squeezed_share = 0;     ///< Of the area: faces with less than a quarter of the texels that their area is worth.
    std::size_t lost_faces = 0;    ///< Have area, but less than a millionth of the texels they are worth; not in stretch_l2.
    double seam_length_share = 0;  ///< Of the length of all edges between two faces: those that the atlas cuts.
    std::size_t overlapping_texels = 0;  ///< Texel centres inside two faces or more, by more than a thousandth of a texel.
    std::size_t outside_corners = 0;     ///< Texcoords that are not in [0,1].
};

/// Of a mesh with texcoords, for a texture of size_px². stretch_l2 is the L² norm of Sander et al., "Texture mapping progressive
/// meshes", SIGGRAPH 2001, times the root of the atlas's area over the surface's: 1 when every face keeps its shape and all are
/// of one scale. Two faces are joined across an edge if their texcoords at both ends differ by less than a millionth. Throws
/// std::invalid_argument for a mesh without texcoords or without area.
AtlasFigures atlas_figures(const fresco::Mesh& mesh, int size_px);

}  // namespace bench
