#pragma once

#include <fresco/texture.h>

#include <cstddef>
#include <string>
#include <vector>

namespace fresco::texturing
{

/// Where a PLY file keeps texcoords: there is no standard, readers differ.
enum class PlyTexcoords
{
    vertex,  ///< `s`, `t` of each vertex, which is split where the atlas is cut: what Blender reads.
    face,    ///< `texcoord`, a list of six numbers for each face: what MeshLab reads.
    none
};

/// The mesh as it is to stand in the file: for `vertex`, corners that agree in position and texcoord are one vertex; for `none`
/// without texcoords. `colors` (per vertex of the mesh, or empty) go with their vertices.
Mesh arranged(const Mesh& mesh, const std::vector<Rgb8>& colors, PlyTexcoords texcoords);

/// Binary little-endian PLY of an arranged mesh; `picture`: the name for `comment TextureFile`, empty for none. parse_ply gives
/// the same mesh again but for faces that name a vertex twice. Throws Error for more vertices than PLY's int counts.
std::vector<std::byte> textured_ply(const Mesh& mesh, PlyTexcoords texcoords, const std::string& picture);

}  // namespace fresco::texturing
