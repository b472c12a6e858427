#include "packed_mesh.h"

#include <fresco/error.h>
#include <fresco/html.h>
#include <fresco/preview.h>
#include <fresco/texture.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <limits>

namespace fresco
{
namespace detail
{
namespace
{

constexpr double most = 65535;

std::uint16_t quantized(double share)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * most));
}

struct PackedVertex
{
    std::array<std::uint16_t, 6> values{};
};

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
            if (vertices_[*link].values == vertex.values)
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

}  // namespace

PackedMesh pack_mesh(const Mesh& mesh)
{
    static_assert(std::endian::native == std::endian::little);
    PackedMesh packed_mesh;
    std::array<double, 3> high{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        packed_mesh.low[axis] = high[axis] = coordinates(mesh.positions.at(mesh.triangles.at(0)[0]))[axis];
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            for (std::size_t axis = 0; axis < 3; ++axis)
            {
                const double value = coordinates(mesh.positions[vertex])[axis];
                packed_mesh.low[axis] = std::min(packed_mesh.low[axis], value);
                high[axis] = std::max(high[axis], value);
            }
    for (std::size_t axis = 0; axis < 3; ++axis)
        packed_mesh.extent[axis] = high[axis] - packed_mesh.low[axis];

    VertexTable table(mesh.positions.size());
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * mesh.triangles.size());
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t vertex = mesh.triangles[face][corner];
            const auto position = coordinates(mesh.positions[vertex]);
            const Vec2f uv = mesh.texcoords[3 * face + corner];
            PackedVertex packed;
            for (std::size_t axis = 0; axis < 3; ++axis)
                packed.values[axis] = packed_mesh.extent[axis] > 0
                                          ? quantized((position[axis] - packed_mesh.low[axis]) / packed_mesh.extent[axis])
                                          : std::uint16_t{0};
            packed.values[4] = quantized(uv.x);
            packed.values[5] = quantized(uv.y);
            corners.push_back(table.find_or_add(vertex, packed));
        }
    packed_mesh.vertices = table.vertices().size();
    packed_mesh.triangles = mesh.triangles.size();
    const std::size_t vertex_bytes = packed_mesh.vertices * sizeof(PackedVertex);
    packed_mesh.bytes.resize(vertex_bytes + corners.size() * sizeof(std::uint32_t));
    std::memcpy(packed_mesh.bytes.data(), table.vertices().data(), vertex_bytes);
    std::memcpy(packed_mesh.bytes.data() + vertex_bytes, corners.data(), corners.size() * sizeof(std::uint32_t));
    return packed_mesh;
}

}  // namespace detail

void TexturedMesh::preview(Preview& page) const
{
    constexpr std::size_t most_triangles = 800'000;  // About 20 MB in the page.
    constexpr int texture_px = 2048;
    constexpr int texture_quality = 88;
    const auto numbers = [](const std::array<double, 3>& values) { return Value(Value::List(values.begin(), values.end())); };
    if (!page.last)
        return;
    page.picture(fmt::format("{} × {} texels", image.pixels.width, image.pixels.height), image.pixels,
                 {{"section", "The atlas"}});
    check_mesh(mesh, "the room");
    if (mesh.texcoords.empty())
        throw Error("the room has no texcoords");
    if (mesh.triangles.size() > most_triangles)
        throw Error(
            fmt::format("the room has {} faces, the page takes {} at most: open the exported file, or decimate the mesh further",
                        mesh.triangles.size(), most_triangles));
    const detail::PackedMesh packed = detail::pack_mesh(mesh);
    page.set("room", Value::Map{{"atlas", atlas_id(mesh)},
                                {"vertices", packed.vertices},
                                {"triangles", packed.triangles},
                                {"low", numbers(packed.low)},
                                {"extent", numbers(packed.extent)},
                                {"geometry", base64(packed.bytes)},
                                {"texture", data_uri("image/jpeg", page.images.encode_jpeg(small_copy(image.pixels, texture_px),
                                                                                           texture_quality))}});
}

}  // namespace fresco
