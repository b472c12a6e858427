#pragma once

#include <fresco/mesh.h>

#include <array>
#include <cstddef>
#include <vector>

namespace fresco::page
{

/// A mesh for a page, in about 10 bytes per vertex and 4 per face.
struct PackedMesh
{
    std::array<double, 3> low{};     ///< World position of (0, 0, 0).
    std::array<double, 3> extent{};  ///< World size of the range 0..65535.
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    /// Per corner of each face, counter-clockwise: how many vertices ago its vertex first came, 0: it comes now, and x, y, z, u,
    /// v follow, each as its difference to the corner before (0 for the first), of 0..65535, as 0, -1, 1, -2 … Numbers in 7 bits
    /// per byte, the low ones first; the eighth bit says that more follow. Neither faces nor vertices keep their order.
    std::vector<std::byte> bytes;
};

/// Corners of one vertex with one texcoord (to 1/65535) share a packed vertex. A position is moved by at most half of
/// extent/65535, a texcoord outside of [0, 1] to the border. The mesh must have passed check_mesh and have texcoords.
PackedMesh pack_mesh(const Mesh& mesh);

}  // namespace fresco::page
