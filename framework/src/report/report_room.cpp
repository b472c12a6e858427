#include "report/report_room.h"

#include "report/report_figures.h"

#include <fresco/error.h>
#include <fresco/html.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace fresco::host
{
namespace
{

constexpr double most = 65535;
constexpr std::size_t most_triangles = 800'000;  // About 20 MB in the page.
constexpr int texture_px = 2048;
constexpr int texture_quality = 88;

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

Value triple(Vec3d v)
{
    return Value::List{v.x, v.y, v.z};
}

}  // namespace

PackedRoom pack_room(const Mesh& mesh)
{
    static_assert(std::endian::native == std::endian::little);
    PackedRoom room;
    std::array<double, 3> high{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        room.low[axis] = high[axis] = coordinates(mesh.positions.at(mesh.triangles.at(0)[0]))[axis];
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            for (std::size_t axis = 0; axis < 3; ++axis)
            {
                const double value = coordinates(mesh.positions[vertex])[axis];
                room.low[axis] = std::min(room.low[axis], value);
                high[axis] = std::max(high[axis], value);
            }
    for (std::size_t axis = 0; axis < 3; ++axis)
        room.extent[axis] = high[axis] - room.low[axis];

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
                packed.values[axis] =
                    room.extent[axis] > 0 ? quantized((position[axis] - room.low[axis]) / room.extent[axis]) : std::uint16_t{0};
            packed.values[4] = quantized(uv.x);
            packed.values[5] = quantized(uv.y);
            corners.push_back(table.find_or_add(vertex, packed));
        }
    room.vertices = table.vertices().size();
    room.triangles = mesh.triangles.size();
    const std::size_t vertex_bytes = room.vertices * sizeof(PackedVertex);
    room.bytes.resize(vertex_bytes + corners.size() * sizeof(std::uint32_t));
    std::memcpy(room.bytes.data(), table.vertices().data(), vertex_bytes);
    std::memcpy(room.bytes.data() + vertex_bytes, corners.data(), corners.size() * sizeof(std::uint32_t));
    return room;
}

Vec3d upwards(const Frames& frames)
{
    // Of a symmetric matrix: the mean of r rᵀ, less a little of m mᵀ, which decides where all cameras look the same way.
    constexpr double share_of_mean = 0.05;
    constexpr int steps = 200;
    std::vector<Vec3d> rights;
    Vec3d mean;
    for (const Frame& frame : frames.frames)
    {
        rights.push_back(frame.color.world_from_camera.direction({1, 0, 0}));
        mean += frame.color.world_from_camera.direction({0, -1, 0}) * (1.0 / static_cast<double>(frames.frames.size()));
    }
    if (!(length(mean) > 0))
        return {0, 0, 1};
    Vec3d up = normalized(mean);
    // The eigenvector of the smallest eigenvalue, none of which is more than one.
    for (int step = 0; step < steps; ++step)
    {
        Vec3d product = mean * (-share_of_mean * dot(mean, up));
        for (const Vec3d& right : rights)
            product += right * (dot(right, up) / static_cast<double>(rights.size()));
        up = normalized(up - product);
    }
    return dot(up, mean) < 0 ? up * -1.0 : up;
}

Value pose_value(const Camera& camera)
{
    const RigidTransform& world_from_camera = camera.world_from_camera;
    return Value::Map{{"position", triple(world_from_camera.translation)},
                      {"forward", triple(world_from_camera.direction({0, 0, 1}))},
                      {"up", triple(world_from_camera.direction({0, -1, 0}))}};
}

ReportRoom report_room(const std::string& stage, const TexturedMesh& mesh, const Frames* frames, const ImageIo& images)
{
    check_mesh(mesh.mesh, "the room");
    if (mesh.mesh.texcoords.empty())
        throw Error("the room has no texcoords");
    if (mesh.mesh.triangles.size() > most_triangles)
        throw Error("the room has " + figure_text(mesh.mesh.triangles.size()) +
                    " faces, too many for a page that is to turn it (" + figure_text(most_triangles) +
                    " at most): open the exported file, or decimate the mesh further");
    const PackedRoom packed = pack_room(mesh.mesh);
    ReportRoom room;
    room.stage = stage;
    room.vertices = packed.vertices;
    room.triangles = packed.triangles;
    room.low = packed.low;
    room.extent = packed.extent;
    room.geometry = base64(packed.bytes);
    const Raster8& picture = mesh.image.pixels;
    const double scale = std::min(1.0, static_cast<double>(texture_px) / std::max(picture.width, picture.height));
    const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
    room.texture = data_uri(
        "image/jpeg",
        images.encode_jpeg(scale < 1 ? resized(picture, side(picture.width), side(picture.height)) : picture, texture_quality));
    if (frames != nullptr && !frames->frames.empty())
    {
        room.start = pose_value(frames->frames.front().color);
        room.start.set("up", triple(upwards(*frames)));
        Vec3d looking;
        for (const Frame& frame : frames->frames)
            looking += frame.color.world_from_camera.direction({0, 0, 1}) * (1.0 / static_cast<double>(frames->frames.size()));
        room.start.set("looking", triple(looking));
    }
    return room;
}

}  // namespace fresco::host
