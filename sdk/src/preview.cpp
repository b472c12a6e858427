#include "packed_mesh.h"

#include <fresco/camera.h>
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/html.h>
#include <fresco/preview.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

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
    std::array<std::uint16_t, 5> values{};  ///< x, y, z, u, v
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
    PackedVertex before;
    for (const std::size_t face : along_the_surface(corners))
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const std::uint32_t vertex = corners[3 * face + corner];
            const bool is_new = numbers[vertex] == none;
            packer.add(is_new ? 0 : count - numbers[vertex]);
            if (is_new)
            {
                numbers[vertex] = count++;
                for (std::size_t i = 0; i < vertices[vertex].values.size(); ++i)
                    packer.add_signed(vertices[vertex].values[i] - before.values[i]);
            }
            before = vertices[vertex];
        }
    return packer.take();
}

}  // namespace

PackedMesh pack_mesh(const Mesh& mesh)
{
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
            PackedVertex shared;
            for (std::size_t axis = 0; axis < 3; ++axis)
                shared.values[axis] = packed_mesh.extent[axis] > 0
                                          ? quantized((position[axis] - packed_mesh.low[axis]) / packed_mesh.extent[axis])
                                          : std::uint16_t{0};
            shared.values[3] = quantized(uv.x);
            shared.values[4] = quantized(uv.y);
            corners.push_back(table.find_or_add(vertex, shared));
        }
    packed_mesh.vertices = table.vertices().size();
    packed_mesh.triangles = mesh.triangles.size();
    packed_mesh.bytes = packed(table.vertices(), corners);
    return packed_mesh;
}

}  // namespace detail

Value page_room(const Mesh& mesh, std::span<const std::byte> texture)
{
    const auto numbers = [](const std::array<double, 3>& values) { return Value(Value::List(values.begin(), values.end())); };
    const detail::PackedMesh packed = detail::pack_mesh(mesh);
    return Value::Map{{"atlas", atlas_id(mesh)},
                      {"vertices", packed.vertices},
                      {"triangles", packed.triangles},
                      {"low", numbers(packed.low)},
                      {"extent", numbers(packed.extent)},
                      {"geometry", base64(packed.bytes)},
                      {"texture", data_uri("image/jpeg", texture)}};
}

void TexturedMesh::preview(Preview& page) const
{
    constexpr std::size_t most_triangles = 800'000;  // About 11 MB in the page.
    constexpr int texture_px = 2048;
    constexpr int texture_quality = 88;
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
    page.set("room", page_room(mesh, page.images.encode_jpeg(small_copy(image.pixels, texture_px), texture_quality)));
}
namespace
{

Value triple(Vec3d v)
{
    return Value::List{v.x, v.y, v.z};
}

Value::Map pose_of(const Camera& camera)
{
    const RigidTransform& world_from_camera = camera.world_from_camera;
    return {{"position", triple(world_from_camera.translation)},
            {"forward", triple(world_from_camera.direction({0, 0, 1}))},
            {"up", triple(world_from_camera.direction({0, -1, 0}))}};
}

/// The mean of a camera's axis over all frames.
Vec3d mean_direction(const std::vector<Frame>& frames, Vec3d axis)
{
    Vec3d mean;
    for (const Frame& frame : frames)
        mean += frame.color.world_from_camera.direction(axis) * (1.0 / static_cast<double>(frames.size()));
    return mean;
}

std::vector<RigidTransform> poses_of(const std::vector<Frame>& frames)
{
    std::vector<RigidTransform> poses;
    for (const Frame& frame : frames)
        poses.push_back(frame.color.world_from_camera);
    return poses;
}

}  // namespace

Value page_cameras(const Frames& frames)
{
    Value::Map cameras = pose_of(frames.frames.at(0).color);
    cameras[2].second = triple(cameras_up(poses_of(frames.frames)).value_or(Vec3d{0, 0, 1}));
    cameras.emplace_back("looking", triple(mean_direction(frames.frames, {0, 0, 1})));
    return cameras;
}

void Frames::preview(Preview& page) const
{
    std::map<std::string, const Frame*> recorded;
    for (const Frame& frame : frames)
        if (!frame.color_picture.empty())
            recorded.emplace(frame.sequence + "_" + frame.name, &frame);
    std::vector<const Frame*> shown;
    for (const std::string& name : page.names)
        if (const auto found = recorded.find(std::filesystem::path(name).stem().string()); found != recorded.end())
        {
            shown.push_back(found->second);
            recorded.erase(found);  // Several stages may have made pictures of it.
        }
    if (frames.empty() || (shown.empty() && !page.last))
        return;
    page.set("cameras", page_cameras(*this));
    for (const Frame* frame : shown)
        page.picture(frame->sequence + "_" + frame->name, load_color(*frame, &page.images), {{"pose", pose_of(frame->color)}});
}
namespace
{

constexpr int jpeg_quality = 82;
constexpr std::uintmax_t most_video_bytes = 8'000'000;

Raster8 without_alpha(const Raster8& pixels)
{
    Raster8 opaque(pixels.width, pixels.height, 3);
    for (std::size_t i = 0; i < opaque.values.size() / 3; ++i)
        for (std::size_t c = 0; c < 3; ++c)
        {
            const int alpha = pixels.values[4 * i + 3];
            opaque.values[3 * i + c] =
                static_cast<std::uint8_t>((pixels.values[4 * i + c] * alpha + 255 * (255 - alpha) + 127) / 255);
        }
    return opaque;
}

std::string megabytes(std::uintmax_t bytes)
{
    const std::uintmax_t tenths = (bytes + 50'000) / 100'000;
    return fmt::format("{}.{} MB", tenths / 10, tenths % 10);
}

}  // namespace

void Artifact::preview(Preview&) const {}

void Preview::append(std::string_view list, Value entry)
{
    if (value_.find(list) == nullptr)
        value_.set(list, Value::List{});
    value_.find(list)->as_list().push_back(std::move(entry));
}

void Preview::picture(const std::string& name, const Raster8& pixels, Value::Map more)
{
    Value::Map entry{{"name", name},
                     {"uri", data_uri("image/jpeg", images.encode_jpeg(small_copy(pixels, longest_px), jpeg_quality))}};
    std::ranges::move(more, std::back_inserter(entry));
    append("pictures", std::move(entry));
}

void Preview::video(const std::string& name, const std::filesystem::path& file)
{
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    if (bytes > std::min(most_video_bytes, video_bytes))
        throw Error(name + ": a video of " + megabytes(bytes) + " is not put into the page, which takes " +
                    (bytes > most_video_bytes ? megabytes(most_video_bytes) + " at most" : megabytes(video_bytes) + " more") +
                    "; open the file");
    append("pictures",
           Value::Map{{"name", name}, {"uri", data_uri("video/" + file.extension().string().substr(1), read_file(file))}});
    video_bytes -= bytes;
}

void Preview::note(const std::string& text)
{
    append("notes", text);
}

Raster8 small_copy(const Raster8& pixels, int longest_px)
{
    if (pixels.channels == 4)
        return small_copy(without_alpha(pixels), longest_px);
    const double scale = static_cast<double>(longest_px) / std::max(pixels.width, pixels.height);
    const auto side = [&](int px) { return std::max(1, static_cast<int>(std::lround(px * scale))); };
    return scale < 1 ? resized(pixels, side(pixels.width), side(pixels.height)) : pixels;
}

std::vector<std::size_t> evenly_spread(std::size_t size, std::size_t count)
{
    std::vector<std::size_t> chosen;
    const std::size_t taken = std::min(size, count);
    for (std::size_t i = 0; i < taken; ++i)
        chosen.push_back((2 * i + 1) * size / (2 * taken));
    return chosen;
}

bool is_picture(const std::filesystem::path& file)
{
    const std::string extension = file.extension().string();
    return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

}  // namespace fresco
