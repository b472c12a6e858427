#pragma once

#include <fresco/mesh.h>

#include <cstdint>
#include <vector>

namespace fresco::texturing
{

/// A mesh with one texcoord per vertex, as graphics hardware wants it.
struct WeldedMesh
{
    std::vector<Vec3f> positions;        ///< V
    std::vector<Vec3f> normals;          ///< V, unit length: area-weighted over all faces at the position, across seams.
    std::vector<Vec2f> texcoords;        ///< V or empty, origin at the lower left.
    std::vector<Rgb8> colors;            ///< V or empty; sRGB.
    std::vector<std::uint32_t> indices;  ///< 3F, in the order of the mesh's corners.
};

/// Corners with the same position and the same texcoord become one vertex, numbered by first use; no face is dropped. The mesh
/// must have passed check_mesh. `with_colors`: corners of one vertex have the same color, too, and the colors are kept.
WeldedMesh weld(const Mesh& mesh, bool with_colors = false);

}  // namespace fresco::texturing
