#include "mesh_text.h"
#include "ply_cursor.h"
#include "ply_header.h"

#include <fresco/error.h>
#include <fresco/mesh.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <utility>

namespace fresco
{
namespace
{

using namespace detail;

template <class Cursor>
class BodyReader
{
  public:
    BodyReader(Cursor cursor, const PlyHeader& header, const PlyLayout& layout, std::size_t max_triangles, TriangleFan fan,
               MeshMaterials* materials, PlyIntegers* integers)
        : cursor_(std::move(cursor)), header_(header), layout_(layout), max_triangles_(max_triangles), fan_(fan),
          materials_(materials), integers_(integers)
    {
    }

    Mesh read()
    {
        for (const auto& element : header_.elements)
        {
            if (&element == layout_.vertex)
                vertices();
            else if (&element == layout_.face)
                faces();
            else
                cursor_.skip_rows(element);
        }
        cursor_.end();
        if (layout_.has_vertex_texcoords && layout_.texcoord == nullptr)
            spread_vertex_texcoords();
        return std::move(mesh_);
    }

  private:
    float finite(double value, const char* what) const
    {
        const auto narrow = static_cast<float>(value);
        if (!std::isfinite(narrow))
            cursor_.fail(std::string(what) + " is not a finite number that fits a float");
        return narrow;
    }

    void vertices()
    {
        const std::size_t count = layout_.vertex->count;
        const auto& properties = layout_.vertex->properties;
        mesh_.positions.reserve(count);
        if (layout_.has_colors)
            mesh_.colors.reserve(count);
        if (layout_.has_vertex_texcoords)
            vertex_texcoords_.reserve(count);
        std::array<double, slot_count> values{};
        for (std::size_t i = 0; i < count; ++i)
        {
            cursor_.begin_row();
            for (std::size_t p = 0; p < properties.size(); ++p)
            {
                const VertexSlot slot = layout_.slots[p];
                const bool is_wanted = &properties[p] == layout_.vertex_integer;
                if (slot == slot_none && is_wanted)
                    integers_->of_vertex.push_back(cursor_.integer(properties[p].type));
                else if (slot == slot_none)
                    cursor_.skip(properties[p]);
                else
                {
                    values[slot] = cursor_.real(properties[p].type);
                    if (slot <= slot_z)
                        finite(values[slot], "the coordinate");
                    else if (slot >= slot_u)
                        finite(values[slot], "the texture coordinate");
                    else if (is_wanted)
                        integers_->of_vertex.push_back(static_cast<std::int64_t>(values[slot]));
                }
            }
            cursor_.end_row();
            mesh_.positions.push_back(
                {static_cast<float>(values[slot_x]), static_cast<float>(values[slot_y]), static_cast<float>(values[slot_z])});
            if (layout_.has_colors)
                mesh_.colors.push_back({static_cast<std::uint8_t>(values[slot_red]),
                                        static_cast<std::uint8_t>(values[slot_green]),
                                        static_cast<std::uint8_t>(values[slot_blue])});
            if (layout_.has_vertex_texcoords)
                vertex_texcoords_.push_back({static_cast<float>(values[slot_u]), static_cast<float>(values[slot_v])});
        }
    }

    void faces()
    {
        const std::size_t count = layout_.face->count;
        mesh_.triangles.reserve(count);
        if (layout_.texcoord != nullptr)
            mesh_.texcoords.reserve(count * 3);
        if (layout_.chart != nullptr)
            mesh_.charts.reserve(count);
        for (std::size_t i = 0; i < count; ++i)
        {
            cursor_.begin_row();
            std::uint32_t chart = 0;
            for (const auto& property : layout_.face->properties)
            {
                if (&property == layout_.indices)
                    indices();
                else if (&property == layout_.texcoord)
                    texcoords();
                else if (&property == layout_.chart)
                    chart = read_chart();
                else if (&property == layout_.picture)
                    picture_ = read_picture();
                else if (&property == layout_.face_integer)
                    integer_ = cursor_.integer(property.type);
                else
                    cursor_.skip(property);
                if (&property == layout_.face_integer && &property == layout_.chart)
                    integer_ = chart;
                else if (&property == layout_.face_integer && &property == layout_.picture)
                    integer_ = picture_ == MeshMaterials::none ? -1 : std::int64_t{picture_};
            }
            cursor_.end_row();
            add_face(chart);
        }
    }

    void indices()
    {
        const std::size_t size = cursor_.list_size(*layout_.indices);
        if (size < least_corners)
            cursor_.fail(fmt::format("a face of {} corners; expected 3 or more", size));
        corners_.resize(size);
        const auto vertex_count = static_cast<std::int64_t>(layout_.vertex->count);
        for (auto& corner : corners_)
        {
            const std::int64_t index = cursor_.integer(layout_.indices->type);
            if (index < 0 || index >= vertex_count)
                cursor_.fail(fmt::format("the face names vertex {}; expected 0 to {}", index, vertex_count - 1));
            corner = static_cast<std::uint32_t>(index);
        }
    }

    void texcoords()
    {
        const std::size_t size = cursor_.list_size(*layout_.texcoord);
        if (size % 2 != 0)
            cursor_.fail(fmt::format("the list 'texcoord' has {} items; expected u and v per corner", size));
        corner_texcoords_.resize(size / 2);
        for (auto& uv : corner_texcoords_)
        {
            uv.x = finite(cursor_.real(layout_.texcoord->type), "the texture coordinate");
            uv.y = finite(cursor_.real(layout_.texcoord->type), "the texture coordinate");
        }
    }

    std::uint32_t read_chart()
    {
        const std::int64_t chart = cursor_.integer(layout_.chart->type);
        if (chart < 0)
            cursor_.fail(fmt::format("chart {}; expected 0 or more", chart));
        return static_cast<std::uint32_t>(chart);
    }

    /// -1 stands for none.
    std::uint32_t read_picture()
    {
        const std::int64_t number = cursor_.integer(layout_.picture->type);
        if (number >= static_cast<std::int64_t>(header_.pictures.size()) && materials_ != nullptr)
            cursor_.fail(fmt::format("texnumber {}, but the header names {} pictures ('comment TextureFile NAME')", number,
                                     header_.pictures.size()));
        return number < 0 ? MeshMaterials::none : static_cast<std::uint32_t>(number);
    }

    void add_face(std::uint32_t chart)
    {
        const bool textured = layout_.texcoord != nullptr;
        if (textured && corner_texcoords_.size() != corners_.size())
            cursor_.fail(fmt::format("a face of {} corners has {} texture coordinates; expected one per corner", corners_.size(),
                                     corner_texcoords_.size()));
        fan_.split(corners_,
                   [&](std::size_t a, std::size_t b, std::size_t c)
                   {
                       mesh_.triangles.push_back({corners_[a], corners_[b], corners_[c]});
                       if (textured)
                           for (const std::size_t corner : {a, b, c})
                               mesh_.texcoords.push_back(corner_texcoords_[corner]);
                       if (layout_.chart != nullptr)
                           mesh_.charts.push_back(chart);
                       if (layout_.picture != nullptr && materials_ != nullptr)
                           materials_->of_face.push_back(picture_);
                       if (layout_.face_integer != nullptr)
                           integers_->of_face.push_back(integer_);
                   });
        if (mesh_.triangles.size() > max_triangles_)
            cursor_.fail(fmt::format("more than {} triangles, the limit", max_triangles_));
    }

    void spread_vertex_texcoords()
    {
        mesh_.texcoords.reserve(mesh_.triangles.size() * 3);
        for (const Triangle& triangle : mesh_.triangles)
            for (const std::uint32_t corner : triangle)
                mesh_.texcoords.push_back(vertex_texcoords_[corner]);
    }

    Cursor cursor_;
    const PlyHeader& header_;
    const PlyLayout& layout_;
    std::size_t max_triangles_;
    TriangleFan fan_;
    Mesh mesh_;
    std::vector<Vec2f> vertex_texcoords_;
    std::vector<std::uint32_t> corners_;
    std::vector<Vec2f> corner_texcoords_;
    MeshMaterials* materials_;
    std::uint32_t picture_ = MeshMaterials::none;
    PlyIntegers* integers_;
    std::int64_t integer_ = 0;
};

void check_limits(const PlyLayout& layout, const MeshLimits& limits, std::string_view source)
{
    const std::string begin = std::string(source) + ":";
    if (layout.vertex->count > std::min<std::size_t>(limits.max_vertices, UINT32_MAX))
        throw Error(fmt::format("{}{}: {} vertices; the limit is {}", begin, layout.vertex->line, layout.vertex->count,
                                limits.max_vertices));
    if (layout.face->count > limits.max_faces)
        throw Error(
            fmt::format("{}{}: {} faces; the limit is {}", begin, layout.face->line, layout.face->count, limits.max_faces));
    if (layout.face->count == 0)
        throw Error(fmt::format("{}{}: the file holds no faces; export the scan as a triangle mesh, not as points", begin,
                                layout.face->line));
}

}  // namespace

Mesh detail::parse_ply_faces(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits,
                             MeshReadReport* report, DegenerateFaces degenerate, MeshMaterials* materials, PlyIntegers* integers)
{
    const PlyHeader header = parse_ply_header(bytes, source);
    const PlyLayout layout = ply_layout(header, source, integers != nullptr ? &integers->property : nullptr);
    check_limits(layout, limits, source);

    MeshReadReport counted;
    const TriangleFan fan(counted, degenerate);
    const auto read = [&](auto cursor)
    { return BodyReader(std::move(cursor), header, layout, limits.max_faces, fan, materials, integers).read(); };
    constexpr bool machine_is_little = std::endian::native == std::endian::little;
    Mesh mesh;
    if (header.format == PlyFormat::ascii)
        mesh = read(AsciiCursor(bytes, header, source));
    else if ((header.format == PlyFormat::little_endian) == machine_is_little)
        mesh = read(BinaryCursor<false>(bytes, header, source));
    else
        mesh = read(BinaryCursor<true>(bytes, header, source));

    if (mesh.triangles.empty())
        throw Error(std::string(source) + ": every face names a vertex twice; no triangle is left");
    if (!mesh.texcoords.empty())
        mesh.texture_px = header.texture_px;
    if (report != nullptr)
        *report = counted;
    if (materials != nullptr)
        materials->files = header.pictures;
    return mesh;
}

Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report)
{
    return detail::parse_ply_faces(bytes, source, limits, report, detail::DegenerateFaces::drop);
}

Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               MeshMaterials& materials)
{
    materials = {};
    return detail::parse_ply_faces(bytes, source, limits, report, detail::DegenerateFaces::drop, &materials);
}

Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               PlyIntegers& integers)
{
    integers.of_vertex.clear();
    integers.of_face.clear();
    return detail::parse_ply_faces(bytes, source, limits, report, detail::DegenerateFaces::drop, nullptr, &integers);
}
namespace
{

class PlyWriter
{
  public:
    explicit PlyWriter(std::vector<std::byte>& bytes, std::size_t offset) : next_(bytes.data() + offset) {}

    template <class T>
    void put(T value)
    {
        auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
        if constexpr (std::endian::native == std::endian::big)
            std::reverse(raw.begin(), raw.end());
        std::memcpy(next_, raw.data(), sizeof(T));
        next_ += sizeof(T);
    }

  private:
    std::byte* next_;
};

std::string header_of(const Mesh& mesh)
{
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    if (!mesh.texcoords.empty() && mesh.texture_px > 0)
        text += fmt::format("comment texture_px {}\n", mesh.texture_px);
    text += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.positions.size());
    if (!mesh.colors.empty())
        text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", mesh.triangles.size());
    if (!mesh.texcoords.empty())
        text += "property list uchar float texcoord\n";
    if (!mesh.charts.empty())
        text += "property int chart\n";
    return text + "end_header\n";
}

void check_fits_int(const Mesh& mesh)
{
    constexpr std::uint32_t greatest = std::numeric_limits<std::int32_t>::max();
    if (mesh.positions.size() > greatest)
        throw Error(fmt::format("a PLY file holds at most {} vertices, not {}", greatest, mesh.positions.size()));
    for (const std::uint32_t chart : mesh.charts)
        if (chart > greatest)
            throw Error(fmt::format("a PLY file holds chart numbers up to {}, not {}", greatest, chart));
}

}  // namespace

std::vector<std::byte> to_ply(const Mesh& mesh)
{
    check_mesh(mesh, "mesh to be written as PLY");
    check_fits_int(mesh);
    const std::string header = header_of(mesh);
    const std::size_t vertex_bytes = 12 + (mesh.colors.empty() ? 0U : 3U);
    const std::size_t face_bytes = 13 + (mesh.texcoords.empty() ? 0U : 25U) + (mesh.charts.empty() ? 0U : 4U);
    std::vector<std::byte> bytes(header.size() + mesh.positions.size() * vertex_bytes + mesh.triangles.size() * face_bytes);
    std::memcpy(bytes.data(), header.data(), header.size());

    PlyWriter out(bytes, header.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        out.put(mesh.positions[i].x);
        out.put(mesh.positions[i].y);
        out.put(mesh.positions[i].z);
        if (!mesh.colors.empty())
            for (const std::uint8_t channel : mesh.colors[i])
                out.put(channel);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        out.put(std::uint8_t{3});
        for (const std::uint32_t corner : mesh.triangles[i])
            out.put(corner);
        if (!mesh.texcoords.empty())
        {
            out.put(std::uint8_t{6});
            for (std::size_t corner = 3 * i; corner < 3 * i + 3; ++corner)
            {
                out.put(mesh.texcoords[corner].x);
                out.put(mesh.texcoords[corner].y);
            }
        }
        if (!mesh.charts.empty())
            out.put(mesh.charts[i]);
    }
    return bytes;
}

}  // namespace fresco
