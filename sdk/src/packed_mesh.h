#pragma once

#include <fresco/mesh.h>

#include <array>
#include <cstddef>
#include <vector>

namespace fresco::detail
{

/// A mesh for a page, in 12 bytes per vertex and per face.
struct PackedMesh
{
    std::array<double, 3> low{};     ///< World position of (0, 0, 0).
    std::array<double, 3> extent{};  ///< World size of the range 0..65535.
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    /// Per vertex six uint16: x, y, z, 0, u, v, of which 65535 is the end of the range; then per face three uint32: vertices,
    /// counter-clockwise. Little-endian.
    std::vector<std::byte> bytes;
};

/// Corners of one vertex with one texcoord (to 1/65535) share a packed vertex. A position is moved by at most half of
/// extent/65535, a texcoord outside of [0, 1] to the border. The mesh must have passed check_mesh and have texcoords.
PackedMesh pack_mesh(const Mesh& mesh);

}  // namespace fresco::detail
