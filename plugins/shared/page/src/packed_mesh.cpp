#include "packed_mesh.h"

#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace fresco::page
{
namespace
{

constexpr double most = 65535;

std::uint16_t quantized(double share)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * most));
}

using PackedVertex = std::array<std::uint16_t, 5>;  ///< x, y, z, u, v

std::array<double, 3> coordinates(Vec3f point)
{
    return {point.x, point.y, point.z};
}

/// The faces so that each shares an edge with one shortly before it, where it has such a neighbor: its vertices are then near
/// those that came last, in the order and in the room. Each begins with the corner that it began with.
std::vector<std::uint32_t> along_the_surface(const std::vector<Triangle>& triangles, std::size_t vertices)
{
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::array<std::uint32_t, 3>> neighbors(triangles.size(), {none, none, none});
    geometry::for_each_edge(
        triangles, vertices,
        [&](std::uint32_t, std::uint32_t, std::span<const geometry::EdgeUse> uses)
        {
            for (std::size_t i = 1; i < uses.size(); ++i)
                for (const auto& [face, other] : {std::pair(uses[i - 1].face, uses[i].face), {uses[i].face, uses[i - 1].face}})
                    if (const auto free = std::ranges::find(neighbors[face], none); free != neighbors[face].end())
                        *free = other;
        });

    std::vector<std::uint32_t> order;
    std::vector<bool> is_taken(triangles.size());
    std::vector<std::uint32_t> waiting;
    for (std::uint32_t first = 0; first < triangles.size(); ++first)
    {
        waiting.assign(1, first);
        while (!waiting.empty())
        {
            const std::uint32_t face = waiting.back();
            waiting.pop_back();
            if (is_taken[face])
                continue;
            is_taken[face] = true;
            order.push_back(face);
            for (const std::uint32_t neighbor : neighbors[face])
                if (neighbor != none && !is_taken[neighbor])
                    waiting.push_back(neighbor);
        }
    }
    return order;
}

/// Numbers in 7 bits per byte, the low ones first; the eighth bit says that more follow.
class Packer
{
  public:
    void add(std::uint32_t number)
    {
        for (; number > 127; number >>= 7U)
            bytes_.push_back(static_cast<std::byte>((number & 127U) | 128U));
        bytes_.push_back(static_cast<std::byte>(number));
    }
    /// 0, -1, 1, -2 … as 0, 1, 2, 3 …
    void add_signed(int number)
    {
        add(number < 0 ? 2 * static_cast<std::uint32_t>(-(number + 1)) + 1 : 2 * static_cast<std::uint32_t>(number));
    }
    std::vector<std::byte> take() { return std::move(bytes_); }

  private:
    std::vector<std::byte> bytes_;
};

std::vector<std::byte> packed(const std::vector<PackedVertex>& vertices, const std::vector<Triangle>& triangles)
{
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    Packer packer;
    std::vector<std::uint32_t> numbers(vertices.size(), none);
    std::uint32_t count = 0;
    PackedVertex before{};
    for (const std::uint32_t face : along_the_surface(triangles, vertices.size()))
        for (const std::uint32_t vertex : triangles[face])
        {
            const bool is_new = numbers[vertex] == none;
            packer.add(is_new ? 0 : count - numbers[vertex]);
            if (is_new)
            {
                numbers[vertex] = count++;
                for (std::size_t i = 0; i < before.size(); ++i)
                    packer.add_signed(vertices[vertex][i] - before[i]);
            }
            before = vertices[vertex];
        }
    return packer.take();
}

}  // namespace

PackedMesh pack_mesh(const Mesh& mesh)
{
    numerics::Bounds<float> box;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            box.add(mesh.positions[vertex]);
    PackedMesh packed_mesh;
    packed_mesh.low = coordinates(box.low);
    for (std::size_t axis = 0; axis < 3; ++axis)
        packed_mesh.extent[axis] = coordinates(box.high)[axis] - packed_mesh.low[axis];

    std::vector<PackedVertex> vertices;
    std::vector<std::vector<std::uint32_t>> made_of(mesh.positions.size());
    std::vector<Triangle> triangles = mesh.triangles;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t vertex = mesh.triangles[face][corner];
            const auto position = coordinates(mesh.positions[vertex]);
            const Vec2f uv = mesh.texcoords[3 * face + corner];
            PackedVertex shared{0, 0, 0, quantized(uv.x), quantized(uv.y)};
            for (std::size_t axis = 0; axis < 3; ++axis)
                if (packed_mesh.extent[axis] > 0)
                    shared[axis] = quantized((position[axis] - packed_mesh.low[axis]) / packed_mesh.extent[axis]);
            auto& made = made_of[vertex];
            const auto same = std::ranges::find(made, shared, [&](std::uint32_t index) { return vertices[index]; });
            triangles[face][corner] = same != made.end() ? *same : static_cast<std::uint32_t>(vertices.size());
            if (same == made.end())
            {
                made.push_back(triangles[face][corner]);
                vertices.push_back(shared);
            }
        }
    packed_mesh.vertices = vertices.size();
    packed_mesh.triangles = mesh.triangles.size();
    packed_mesh.bytes = packed(vertices, triangles);
    return packed_mesh;
}

}  // namespace fresco::page
