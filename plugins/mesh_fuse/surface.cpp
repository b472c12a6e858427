#include "surface.h"

#include "cube_cases.h"

#include <fresco/error.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <utility>

using namespace fresco;

namespace fuse
{
namespace
{

constexpr std::size_t grain = 64;  ///< Blocks.
/// Vertices keep this share of an edge away from its ends: faces around an end would have no area.
constexpr float clearance = 0.01F;

constexpr std::array<std::array<int, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

constexpr std::size_t edge_number(int axis, int x, int y, int z)
{
    return static_cast<std::size_t>(axis) * block_size + voxel_index(x, y, z);
}

}  // namespace

/// The distances of a block's voxels and of one more on each side.
class Surface::Surrounding
{
  public:
    Surrounding(const Volume& volume, std::size_t block)
    {
        const BlockPlace& place = volume.places()[block];
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 1; ++y)
                for (int x = -1; x <= 1; ++x)
                    copy(volume, neighbor(x, y, z) = volume.find({place.x + x, place.y + y, place.z + z}), x, y, z);
    }

    /// The block at -1, 0 or 1 along each axis.
    std::size_t& neighbor(int x, int y, int z)
    {
        return neighbors_[static_cast<std::size_t>((x + 1) + 3 * (y + 1) + 9 * (z + 1))];
    }
    /// NaN where nothing was measured. From -1 to block_side.
    float distance(int x, int y, int z) const { return distances_[place(x, y, z)]; }

    /// Whether all corners of the cube that begins there have distances.
    bool is_whole(int x, int y, int z) const
    {
        for (int corner = 0; corner < 8; ++corner)
            if (std::isnan(at_corner(x, y, z, corner)))
                return false;
        return true;
    }

    /// The corners that lie inside, as cube_cases counts them.
    unsigned inside(int x, int y, int z) const
    {
        unsigned bits = 0;
        for (int corner = 0; corner < 8; ++corner)
            bits |= at_corner(x, y, z, corner) < 0 ? 1U << corner : 0U;
        return bits;
    }

    bool crosses(int axis, int x, int y, int z) const
    {
        const auto& step = axes[static_cast<std::size_t>(axis)];
        return (distance(x, y, z) < 0) != (distance(x + step[0], y + step[1], z + step[2]) < 0);
    }

    /// Whether a whole cube lies around an edge of the block.
    bool is_used(int axis, int x, int y, int z) const
    {
        const auto &u = axes[static_cast<std::size_t>((axis + 1) % 3)], &v = axes[static_cast<std::size_t>((axis + 2) % 3)];
        for (int i = 0; i <= 1; ++i)
            for (int j = 0; j <= 1; ++j)
                if (is_whole(x - i * u[0] - j * v[0], y - i * u[1] - j * v[1], z - i * u[2] - j * v[2]))
                    return true;
        return false;
    }

  private:
    static constexpr int side = block_side + 2;

    static std::size_t place(int x, int y, int z)
    {
        return static_cast<std::size_t>((x + 1) + side * ((y + 1) + side * (z + 1)));
    }

    float at_corner(int x, int y, int z, int corner) const
    {
        return distance(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2 & 1));
    }

    void copy(const Volume& volume, std::size_t block, int bx, int by, int bz)
    {
        const auto low = [](int b) { return b < 0 ? -1 : b * block_side; };
        const auto high = [](int b) { return b < 0 ? 0 : b == 0 ? block_side : block_side + 1; };
        for (int z = low(bz); z < high(bz); ++z)
            for (int y = low(by); y < high(by); ++y)
                for (int x = low(bx); x < high(bx); ++x)
                {
                    float& distance = distances_[place(x, y, z)];
                    distance = std::numeric_limits<float>::quiet_NaN();
                    if (block == Volume::none)
                        continue;
                    const Voxel& voxel =
                        volume.block(block)[voxel_index(x - bx * block_side, y - by * block_side, z - bz * block_side)];
                    if (voxel.weight > 0)
                        distance = voxel.distance();
                }
    }

    std::array<std::size_t, 27> neighbors_{};
    std::array<float, static_cast<std::size_t>(side) * side * side> distances_{};
};

Surface::Surface(const Volume& volume, const Progress& progress) : volume_(volume), parts_(volume.places().size())
{
    parallel_for(parts_.size(), grain, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         const Surrounding around(volume_, i);
                         Part& part = parts_[i];
                         for (int z = 0; z < block_side; ++z)
                             for (int y = 0; y < block_side; ++y)
                                 for (int x = 0; x < block_side; ++x)
                                 {
                                     for (int axis = 0; axis < 3; ++axis)
                                         if (around.crosses(axis, x, y, z) && around.is_used(axis, x, y, z))
                                         {
                                             const std::size_t edge = edge_number(axis, x, y, z);
                                             part.has_vertex[edge / 64] |= std::uint64_t{1} << edge % 64;
                                         }
                                     if (around.is_whole(x, y, z))
                                         part.first_face += static_cast<std::size_t>(cube_cases()[around.inside(x, y, z)].count);
                                 }
                     }
                 });
    for (Part& part : parts_)
    {
        part.first_vertex = vertex_count_;
        for (const std::uint64_t word : part.has_vertex)
            vertex_count_ += static_cast<std::size_t>(std::popcount(word));
        face_count_ += std::exchange(part.first_face, face_count_);
    }
}

std::size_t Surface::bytes() const
{
    return parts_.size() * sizeof(Part) + vertex_count_ * sizeof(Vec3f) + face_count_ * sizeof(Triangle);
}

std::size_t Surface::vertex(const Part& part, std::size_t edge) const
{
    std::size_t number = part.first_vertex;
    for (std::size_t word = 0; word < edge / 64; ++word)
        number += static_cast<std::size_t>(std::popcount(part.has_vertex[word]));
    return number + static_cast<std::size_t>(std::popcount(part.has_vertex[edge / 64] & ((std::uint64_t{1} << edge % 64) - 1)));
}

void Surface::write(std::size_t block, Mesh& mesh) const
{
    const Part& own = parts_[block];
    Surrounding around(volume_, block);
    const Vec3d origin = volume_.origin(block);
    std::size_t next_vertex = own.first_vertex;
    for (int axis = 0; axis < 3; ++axis)
        for (int z = 0; z < block_side; ++z)
            for (int y = 0; y < block_side; ++y)
                for (int x = 0; x < block_side; ++x)
                {
                    const std::size_t edge = edge_number(axis, x, y, z);
                    if ((own.has_vertex[edge / 64] >> edge % 64 & 1) == 0)
                        continue;
                    const auto& step = axes[static_cast<std::size_t>(axis)];
                    const float from = around.distance(x, y, z);
                    const float to = around.distance(x + step[0], y + step[1], z + step[2]);
                    const double along = double{std::clamp(from / (from - to), clearance, 1 - clearance)};
                    const Vec3d voxels{x + step[0] * along, y + step[1] * along, z + step[2] * along};
                    mesh.positions[next_vertex++] = vec_cast<float>(origin + voxels * volume_.voxel_m());
                }
    std::size_t next_face = own.first_face;
    for (int z = 0; z < block_side; ++z)
        for (int y = 0; y < block_side; ++y)
            for (int x = 0; x < block_side; ++x)
            {
                if (!around.is_whole(x, y, z))
                    continue;
                const CubeCase& cube = cube_cases()[around.inside(x, y, z)];
                const auto corner = [&](std::uint8_t number)
                {
                    const CubeEdge& edge = cube_edges()[number];
                    const int ex = x + (edge.corner & 1), ey = y + (edge.corner >> 1 & 1), ez = z + (edge.corner >> 2 & 1);
                    const Part& part = parts_[around.neighbor(ex / block_side, ey / block_side, ez / block_side)];
                    return static_cast<std::uint32_t>(
                        vertex(part, edge_number(edge.axis, ex % block_side, ey % block_side, ez % block_side)));
                };
                for (int i = 0; i < cube.count; ++i)
                {
                    const auto& edges = cube.triangles[static_cast<std::size_t>(i)];
                    mesh.triangles[next_face++] = {corner(edges[0]), corner(edges[1]), corner(edges[2])};
                }
            }
}

Mesh Surface::mesh(const Progress& progress) const
{
    if (vertex_count_ > std::numeric_limits<std::uint32_t>::max())
        throw Error(fmt::format("the surface has {} vertices; a mesh has at most 4294967295: raise voxel_m", vertex_count_));
    Mesh mesh;
    mesh.positions.resize(vertex_count_);
    mesh.triangles.resize(face_count_);
    parallel_for(parts_.size(), grain, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = begin; i < end; ++i)
                         write(i, mesh);
                 });
    return mesh;
}

}  // namespace fuse
