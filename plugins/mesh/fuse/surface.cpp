#include "surface.h"

#include <fresco/error.h>
#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

using namespace fresco;

namespace fuse
{
namespace
{

constexpr int corner_count = 8;

std::array<CubeEdge, 12> make_edges()
{
    std::array<CubeEdge, 12> edges{};
    std::size_t count = 0;
    for (int axis = 0; axis < 3; ++axis)
        for (int corner = 0; corner < corner_count; ++corner)
            if ((corner >> axis & 1) == 0)
                edges[count++] = {corner, axis};
    return edges;
}

int edge_between(int a, int b)
{
    const auto& edges = cube_edges();
    const auto found = std::ranges::find_if(edges, [&](const CubeEdge& edge)
                                            { return edge.corner == std::min(a, b) && (1 << edge.axis) == (a ^ b); });
    return static_cast<int>(found - edges.begin());
}

/// The corners of the six faces, counter-clockwise seen from outside the cube.
std::array<std::array<int, 4>, 6> make_faces()
{
    std::array<std::array<int, 4>, 6> faces{};
    for (int axis = 0; axis < 3; ++axis)
    {
        const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, far = 1 << axis;
        faces[static_cast<std::size_t>(2 * axis)] = {0, v, u | v, u};
        faces[static_cast<std::size_t>(2 * axis + 1)] = {far, far | u, far | u | v, far | v};
    }
    return faces;
}

/// Whether two edges of the cube have a face in common.
bool share_face(int first, int second)
{
    const auto lies_in = [](const CubeEdge& edge, int axis, int side)
    { return edge.axis != axis && (edge.corner >> axis & 1) == side; };
    const auto &a = cube_edges()[static_cast<std::size_t>(first)], &b = cube_edges()[static_cast<std::size_t>(second)];
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            if (lies_in(a, axis, side) && lies_in(b, axis, side))
                return true;
    return false;
}

/// Next crossed edge around the surface, for each edge that it crosses.
std::array<int, 12> follow_faces(int inside)
{
    std::array<int, 12> next{};
    next.fill(-1);
    const auto is_inside = [&](int corner) { return (inside >> corner & 1) != 0; };
    for (const std::array<int, 4>& face : make_faces())
        for (std::size_t i = 0; i < 4; ++i)
        {
            if (!is_inside(face[i]) || is_inside(face[(i + 3) % 4]))
                continue;
            std::size_t last = i;
            while (is_inside(face[(last + 1) % 4]))
                last = (last + 1) % 4;
            // Around the corners inside from i to last, which the surface cuts off.
            next[static_cast<std::size_t>(edge_between(face[(i + 3) % 4], face[i]))] =
                edge_between(face[last], face[(last + 1) % 4]);
        }
    return next;
}

/// Adds a polygon as a fan, from a corner whose diagonals lie in no face of the cube: there is one in each case.
void add_fan(const std::vector<int>& loop, CubeCase& result)
{
    const std::size_t count = loop.size();
    const auto fits = [&](std::size_t first)
    {
        for (std::size_t i = 2; i + 1 < count; ++i)
            if (share_face(loop[first], loop[(first + i) % count]))
                return false;
        return true;
    };
    std::size_t first = 0;
    while (first + 1 < count && !fits(first))
        ++first;
    const auto edge = [&](std::size_t i) { return static_cast<std::uint8_t>(loop[(first + i) % count]); };
    for (std::size_t i = 1; i + 1 < count; ++i)
        result.triangles[static_cast<std::size_t>(result.count++)] = {edge(0), edge(i), edge(i + 1)};
}

CubeCase make_case(int inside)
{
    CubeCase result;
    std::array<int, 12> next = follow_faces(inside);
    for (int& start : next)
    {
        std::vector<int> loop;
        for (int* at = &start; *at >= 0;)
        {
            const int edge = *at;
            *at = -1;
            loop.push_back(edge);
            at = &next[static_cast<std::size_t>(edge)];
        }
        if (!loop.empty())
            add_fan(loop, result);
    }
    return result;
}

}  // namespace

const std::array<CubeEdge, 12>& cube_edges()
{
    static const std::array<CubeEdge, 12> edges = make_edges();
    return edges;
}

const std::array<CubeCase, 256>& cube_cases()
{
    static const std::array<CubeCase, 256> cases = []
    {
        std::array<CubeCase, 256> all{};
        for (int inside = 0; inside < 256; ++inside)
            all[static_cast<std::size_t>(inside)] = make_case(inside);
        return all;
    }();
    return cases;
}

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

Surface::Surface(const Volume& volume, const Progress& progress) : volume_(volume), blocks_(volume.places().size())
{
    parallel_items(blocks_.size(), grain, progress,
                   [&](std::size_t i)
                   {
                       const Surrounding around(volume_, i);
                       BlockSurface& part = blocks_[i];
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
                   });
    for (BlockSurface& part : blocks_)
    {
        part.first_vertex = vertex_count_;
        for (const std::uint64_t word : part.has_vertex)
            vertex_count_ += static_cast<std::size_t>(std::popcount(word));
        face_count_ += std::exchange(part.first_face, face_count_);
    }
}

std::size_t Surface::bytes() const
{
    return blocks_.size() * sizeof(BlockSurface) + vertex_count_ * sizeof(Vec3f) + face_count_ * sizeof(Triangle);
}

std::size_t Surface::vertex(const BlockSurface& part, std::size_t edge) const
{
    std::size_t number = part.first_vertex;
    for (std::size_t word = 0; word < edge / 64; ++word)
        number += static_cast<std::size_t>(std::popcount(part.has_vertex[word]));
    return number + static_cast<std::size_t>(std::popcount(part.has_vertex[edge / 64] & ((std::uint64_t{1} << edge % 64) - 1)));
}

void Surface::write(std::size_t block, Mesh& mesh) const
{
    const BlockSurface& own = blocks_[block];
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
                    const BlockSurface& part = blocks_[around.neighbor(ex / block_side, ey / block_side, ez / block_side)];
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
    parallel_items(blocks_.size(), grain, progress, [&](std::size_t i) { write(i, mesh); });
    return mesh;
}

std::size_t remove_small_components(double min_area_m2, Mesh& mesh)
{
    numerics::DisjointSets sets(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
    {
        sets.join(t[0], t[1]);
        sets.join(t[1], t[2]);
    }
    std::vector<double> areas(mesh.positions.size(), 0);
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        areas[sets.find(mesh.triangles[face][0])] += length(geometry::area_vector(mesh, face)) / 2;
    const auto count =
        static_cast<std::size_t>(std::ranges::count_if(areas, [&](double area) { return area > 0 && area < min_area_m2; }));
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return areas[sets.find(t[0])] < min_area_m2; });
    geometry::drop_unused_vertices(mesh);
    return count;
}

}  // namespace fuse
