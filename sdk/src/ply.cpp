#include "mesh_builder.h"
#include "ply_cursor.h"
#include "ply_header.h"

#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <initializer_list>
#include <optional>
#include <utility>

namespace fresco
{
namespace
{

using namespace detail;

// Where a vertex property goes; the rest is skipped.
enum VertexSlot : std::size_t
{
    slot_x,
    slot_y,
    slot_z,
    slot_red,
    slot_green,
    slot_blue,
    slot_u,
    slot_v,
    slot_count,
    slot_none = slot_count
};

constexpr std::array<std::pair<std::string_view, std::string_view>, 4> texcoord_names{
    {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};

/// What the header says about the two elements a mesh is made of.
struct Layout
{
    const PlyElement* vertex = nullptr;
    const PlyElement* face = nullptr;
    std::vector<VertexSlot> slots;  ///< One per vertex property.
    const PlyProperty* indices = nullptr;
    const PlyProperty* texcoord = nullptr;
    const PlyProperty* chart = nullptr;
    const PlyProperty* picture = nullptr;         ///< The face property `texnumber`, if the caller wants it.
    const PlyProperty* vertex_integer = nullptr;  ///< What PlyIntegers names.
    const PlyProperty* face_integer = nullptr;
    bool has_colors = false;
    bool has_vertex_texcoords = false;
};

class LayoutReader
{
  public:
    LayoutReader(const PlyHeader& header, std::string_view source) : header_(header), source_(source) {}

    void find_integers(Layout& layout, const std::string& name) const
    {
        layout.vertex_integer = integer(*layout.vertex, name);
        layout.face_integer = integer(*layout.face, name);
        if (layout.vertex_integer != nullptr || layout.face_integer != nullptr)
            return;
        std::vector<std::string> there;
        for (const PlyElement* element : {layout.vertex, layout.face})
            for (const auto& property : element->properties)
                if (!property.is_list && is_integer(property.type))
                    there.push_back(property.name);
        fail("neither vertices nor faces have an integer property " + in_quotes(name) + suggestion(name, there));
    }

    Layout read()
    {
        layout_.vertex = &element("vertex");
        layout_.face = &element("face");
        vertex();
        face();
        return std::move(layout_);
    }

  private:
    [[noreturn]] void fail(const std::string& what) const { throw Error(std::string(source_) + ": header: " + what); }

    const PlyElement& element(std::string_view name) const
    {
        for (const auto& element : header_.elements)
            if (element.name == name)
                return element;
        fail("missing element " + in_quotes(name) + "; export the scan as a triangle mesh");
    }

    static const PlyProperty* integer(const PlyElement& element, std::string_view name)
    {
        for (const auto& property : element.properties)
            if (property.name == name && !property.is_list && is_integer(property.type))
                return &property;
        return nullptr;
    }

    static std::optional<std::size_t> find(const PlyElement& element, std::string_view name)
    {
        for (std::size_t i = 0; i < element.properties.size(); ++i)
            if (element.properties[i].name == name)
                return i;
        return std::nullopt;
    }

    void vertex()
    {
        const PlyElement& vertex = *layout_.vertex;
        layout_.slots.assign(vertex.properties.size(), slot_none);
        const bool positions = take(slot_x, {"x", "y", "z"}, "float or double", [](PlyType t) { return !is_integer(t); });
        if (!positions)
            fail("element 'vertex' has no properties x, y, z");
        layout_.has_colors = take(slot_red, {"red", "green", "blue"}, "uchar", [](PlyType t) { return t == PlyType::uint8; });
        for (const auto& [u, v] : texcoord_names)
            layout_.has_vertex_texcoords =
                layout_.has_vertex_texcoords || take(slot_u, {u, v}, "float or double", [](PlyType t) { return !is_integer(t); });
    }

    /// Gives the named properties to the slots from `first` on: all of them or none.
    template <class F>
    bool take(VertexSlot first, std::initializer_list<std::string_view> names, std::string_view expected, F&& accepts)
    {
        std::size_t found = 0;
        for (const auto name : names)
            found += find(*layout_.vertex, name).has_value() ? 1 : 0;
        if (found == 0)
            return false;
        std::size_t slot = first;
        for (const auto name : names)
        {
            const auto at = find(*layout_.vertex, name);
            if (!at)
                fail("the vertex property " + in_quotes(name) + " is missing, though others of its group are there");
            const PlyProperty& property = layout_.vertex->properties[*at];
            if (property.is_list || !accepts(property.type))
                fail("the vertex property " + in_quotes(name) + " must be of type " + std::string(expected));
            layout_.slots[*at] = static_cast<VertexSlot>(slot++);
        }
        return true;
    }

    void face()
    {
        for (const auto& property : layout_.face->properties)
        {
            if (is_index_list(*layout_.face, property))
            {
                if (layout_.indices != nullptr)
                    fail("element 'face' has both vertex_indices and vertex_index");
                if (!is_integer(property.type))
                    fail("the face property " + in_quotes(property.name) + " must be a list of an integer type");
                layout_.indices = &property;
            }
            else if (property.name == "texcoord")
            {
                if (!property.is_list || is_integer(property.type))
                    fail("the face property 'texcoord' must be a list of float or double");
                layout_.texcoord = &property;
            }
            else if (property.name == "chart")
            {
                if (property.is_list || !is_integer(property.type))
                    fail("the face property 'chart' must be of an integer type");
                layout_.chart = &property;
            }
            else if (property.name == "texnumber" && !property.is_list && is_integer(property.type))
                layout_.picture = &property;
        }
        if (layout_.indices == nullptr)
            fail("element 'face' has no list vertex_indices");
    }

    const PlyHeader& header_;
    std::string_view source_;
    Layout layout_;
};

template <class Cursor>
class BodyReader
{
  public:
    BodyReader(Cursor cursor, const PlyHeader& header, const Layout& layout, std::size_t max_triangles, TriangleFan fan,
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
                if (slot == slot_none && &properties[p] == layout_.vertex_integer)
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
    const Layout& layout_;
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

void check_limits(const Layout& layout, const MeshLimits& limits, std::string_view source)
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
    LayoutReader reader(header, source);
    Layout layout = reader.read();
    if (integers != nullptr)
        reader.find_integers(layout, integers->property);
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

}  // namespace fresco
