#include "packed_mesh.h"

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

/// Finds the packed vertex of a corner: those of one vertex of the mesh are chained.
class VertexTable
{
  public:
    explicit VertexTable(std::size_t mesh_vertices) : first_(mesh_vertices, none) {}

    std::uint32_t find_or_add(std::uint32_t mesh_vertex, const PackedVertex& vertex)
    {
        std::uint32_t* link = &first_[mesh_vertex];
        while (*link != none)
        {
            if (vertices_[*link] == vertex)
                return *link;
            link = &next_[*link];
        }
        const auto index = static_cast<std::uint32_t>(vertices_.size());
        *link = index;  // Before next_ grows and moves what `link` points into.
        vertices_.push_back(vertex);
        next_.push_back(none);
        return index;
    }
    const std::vector<PackedVertex>& vertices() const { return vertices_; }

  private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> first_;
    std::vector<std::uint32_t> next_;
    std::vector<PackedVertex> vertices_;
};

std::array<double, 3> coordinates(Vec3f point)
{
    return {point.x, point.y, point.z};
}

/// The faces so that each shares an edge with one shortly before it, where it has such a neighbor: its vertices are then near
/// those that came last, in the order and in the room. Each begins with the corner that it began with.
std::vector<std::size_t> along_the_surface(const std::vector<std::uint32_t>& corners)
{
    struct Edge
    {
        std::uint32_t low;
        std::uint32_t high;
        std::uint32_t face;
        auto operator<=>(const Edge&) const = default;
    };
    const std::size_t faces = corners.size() / 3;
    std::vector<Edge> edges;
    edges.reserve(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
    {
        const auto [low, high] = std::minmax(corners[i], corners[i / 3 * 3 + (i + 1) % 3]);
        edges.push_back({low, high, static_cast<std::uint32_t>(i / 3)});
    }
    std::ranges::sort(edges);
    const auto are_one = [](const Edge& a, const Edge& b) { return a.low == b.low && a.high == b.high; };
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::array<std::uint32_t, 3>> neighbors(faces, {none, none, none});
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (are_one(edges[i - 1], edges[i]))
            for (const auto& [face, other] : {std::pair(edges[i - 1].face, edges[i].face), {edges[i].face, edges[i - 1].face}})
                if (const auto free = std::ranges::find(neighbors[face], none); free != neighbors[face].end())
                    *free = other;

    std::vector<std::size_t> order;
    order.reserve(faces);
    std::vector<bool> is_taken(faces);
    std::vector<std::uint32_t> waiting;
    for (std::size_t first = 0; first < faces; ++first)
    {
        waiting.assign(1, static_cast<std::uint32_t>(first));
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

std::vector<std::byte> packed(const std::vector<PackedVertex>& vertices, const std::vector<std::uint32_t>& corners)
{
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    Packer packer;
    std::vector<std::uint32_t> numbers(vertices.size(), none);
    std::uint32_t count = 0;
    PackedVertex before{};
    for (const std::size_t face : along_the_surface(corners))
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t vertex = corners[3 * face + corner];
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

    VertexTable table(mesh.positions.size());
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * mesh.triangles.size());
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
            corners.push_back(table.find_or_add(vertex, shared));
        }
    packed_mesh.vertices = table.vertices().size();
    packed_mesh.triangles = mesh.triangles.size();
    packed_mesh.bytes = packed(table.vertices(), corners);
    return packed_mesh;
}

}  // namespace fresco::page
