#pragma once

#include "integration.h"

#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

/// \file Makes the stage's mesh from a fused volume: marching cubes, and the removal of small components.

namespace fuse
{

/// An edge of a cube, from a corner along an axis. Bit k of a corner's number is set if it is at the far end of axis k.
struct CubeEdge
{
    int corner = 0;
    int axis = 0;
};

/// The triangles of marching cubes in a cube. Each is three edges that its corners lie on, counter-clockwise seen from outside.
struct CubeCase
{
    int count = 0;
    std::array<std::array<std::uint8_t, 3>, 5> triangles{};
};

const std::array<CubeEdge, 12>& cube_edges();

/// Indexed by the corners inside the surface: bit i for corner i. If the corners of a face alternate between inside and outside,
/// the surface cuts off those inside, in both cubes of the face, so that there are no cracks (Lorensen and Cline, "Marching
/// cubes", 1987, left this open). No edge between two triangles of a cube lies in one of its faces, so no edge has more than two
/// triangles.
const std::array<CubeCase, 256>& cube_cases();

/// The surface in a volume, by marching cubes: the zero of the distances between voxels with weights. Every vertex is shared by
/// all faces around it, in any block, and every face has an area; faces run counter-clockwise seen from the side of positive
/// distances. The surface ends at cubes with corners without weight. Vertices and faces are counted first, so that the size is
/// known before the mesh is made.
class Surface
{
  public:
    /// The volume must outlive this.
    Surface(const Volume& volume, const fresco::Progress& progress);

    /// Memory of the mesh and of making it.
    std::size_t bytes() const;
    /// Without colors. Throws fresco::Error for more vertices than a mesh can number.
    fresco::Mesh mesh(const fresco::Progress& progress) const;

  private:
    static constexpr std::size_t edge_words = 3 * block_size / 64;

    /// The share of one block: vertices on the edges that begin at its voxels, faces of the cubes that do.
    struct BlockSurface
    {
        std::array<std::uint64_t, edge_words> has_vertex{};  ///< Bit 512 · axis + voxel.
        std::size_t first_vertex = 0;
        std::size_t first_face = 0;
    };
    class Surrounding;

    std::size_t vertex(const BlockSurface& part, std::size_t edge) const;
    void write(std::size_t block, fresco::Mesh& mesh) const;

    const Volume& volume_;
    std::vector<BlockSurface> blocks_;
    std::size_t vertex_count_ = 0;
    std::size_t face_count_ = 0;
};

/// Removes components (faces connected through vertices) with less than this area, and vertices without faces. Returns the number
/// of removed components. Keeps the order of the rest. The mesh has positions and triangles only.
std::size_t remove_small_components(double min_area_m2, fresco::Mesh& mesh);

}  // namespace fuse
