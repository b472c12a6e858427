#pragma once

#include "volume.h"

#include <fresco/mesh.h>
#include <fresco/progress.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fuse
{

/// The surface in a volume, by marching cubes: the zero of the distances between voxels with weights. Every vertex is shared by
/// all faces around it, in any block, and every face has an area; faces run counter-clockwise seen from the side of positive
/// distances. Where only some corners of a cube have weights, the surface ends. Counted first, so that its size is known before
/// it is made.
class Surface
{
  public:
    /// The volume must outlive this.
    Surface(const Volume& volume, const fresco::Progress& progress);

    /// Of the mesh, and of what finding it takes.
    std::size_t bytes() const;
    /// Without colors. Throws fresco::Error where a mesh cannot number its vertices.
    fresco::Mesh mesh(const fresco::Progress& progress) const;

  private:
    static constexpr std::size_t edge_words = 3 * block_size / 64;

    /// What a block brings: vertices on the edges that begin at its voxels, faces of the cubes that do.
    struct Part
    {
        std::array<std::uint64_t, edge_words> has_vertex{};  ///< Bit 512 · axis + voxel.
        std::size_t first_vertex = 0;
        std::size_t first_face = 0;
    };
    class Surrounding;

    std::size_t vertex(const Part& part, std::size_t edge) const;
    void write(std::size_t block, fresco::Mesh& mesh) const;

    const Volume& volume_;
    std::vector<Part> parts_;
    std::size_t vertex_count_ = 0;
    std::size_t face_count_ = 0;
};

}  // namespace fuse
