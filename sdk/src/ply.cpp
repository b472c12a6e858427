#include "mesh_text.h"
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
#include <map>
#include <string>
#include <utility>

namespace fresco
{
namespace
{

using namespace detail;

// Two sources of values with one interface: rows begin and end, numbers are read by their declared type, lists are checked
// against what is left of the file before anyone allocates for them.

/// Values of the binary formats; `Swapped`: the file's byte order is not this machine's.
template <bool Swapped>
class BinaryCursor
{
  public:
    BinaryCursor(std::span<const std::byte> bytes, const PlyHeader& header, std::string_view source)
        : bytes_(bytes), source_(source), offset_(header.body_offset), last_(offset_)
    {
    }

    void begin_row() {}
    void end_row() {}
    void judge_last(std::int64_t /*value*/, std::int64_t /*greatest*/) {}
    void end()
    {
        last_ = offset_;
        if (offset_ != bytes_.size())
            fail(fmt::format("{} bytes after the last element; expected the end of the file", bytes_.size() - offset_));
    }

    std::int64_t integer(PlyType type)
    {
        switch (type)
        {
        case PlyType::int8:
            return take<std::int8_t>();
        case PlyType::uint8:
            return take<std::uint8_t>();
        case PlyType::int16:
            return take<std::int16_t>();
        case PlyType::uint16:
            return take<std::uint16_t>();
        case PlyType::int32:
            return take<std::int32_t>();
        default:
            return take<std::uint32_t>();
        }
    }

    double real(PlyType type)
    {
        if (type == PlyType::float32)
            return static_cast<double>(take<float>());
        if (type == PlyType::float64)
            return take<double>();
        return static_cast<double>(integer(type));
    }

    /// Whether the rest of the file can hold a list.
    void check_room(const PlyProperty& list, std::size_t items) const
    {
        if (items > (bytes_.size() - offset_) / size_of(list.type))
            fail(fmt::format("the list {} of {} items goes beyond the end of the file: it is cut or damaged",
                             in_quotes(list.name), items));
    }

    void skip(PlyType type, std::size_t items)
    {
        reach(items * size_of(type));
        offset_ += items * size_of(type);
    }

    /// About the value read last.
    [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}: byte {}: {}", source_, last_, what)); }

  private:
    void reach(std::size_t size)
    {
        last_ = offset_;
        if (size > bytes_.size() - offset_)
            fail("the file ends here: it is cut; copy or export it again");
    }

    template <class T>
    T take()
    {
        reach(sizeof(T));
        std::array<std::byte, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes_.data() + offset_, sizeof(T));
        if constexpr (Swapped)
            std::reverse(raw.begin(), raw.end());
        offset_ += sizeof(T);
        return std::bit_cast<T>(raw);
    }

    std::span<const std::byte> bytes_;
    std::string_view source_;
    std::size_t offset_;
    std::size_t last_;
};

/// Values of the text format: one row per line, whose other numbers at the end are ignored. A last line without an end is taken
/// as cut if its last value could go on.
class AsciiCursor
{
  public:
    AsciiCursor(std::span<const std::byte> bytes, const PlyHeader& header, std::string_view source)
        : lines_(as_text(bytes).substr(header.body_offset), source, header.lines, true)
    {
    }

    void begin_row()
    {
        std::string_view line;
        if (!lines_.next(line))
            fail("the file ends after this line: it is cut; copy or export it again");
        words_ = Words(line);
    }
    void end_row()
    {
        double ignored = 0;
        for (auto word = words_.next(); !word.empty(); word = words_.next())
        {
            if (!parse_number(word, ignored))
                fail("unexpected " + in_quotes(word) + " after the last value of the line");
            may_go_on_ = false;
        }
        if (lines_.is_open() && may_go_on_)
            lines_.fail_open();
    }
    /// `value`, the last number read, could go on if with one digit more it would not be above `greatest`.
    void judge_last(std::int64_t value, std::int64_t greatest) { may_go_on_ = value != 0 && std::abs(value) <= greatest / 10; }
    void end()
    {
        std::string_view line;
        while (lines_.next(line))
            if (const auto word = Words(line).next(); !word.empty())
                fail("unexpected " + in_quotes(word) + " after the last element; expected the end of the file");
    }

    std::int64_t integer(PlyType type)
    {
        // Signed types have even numbers.
        const bool is_signed = static_cast<unsigned>(type) % 2 == 0;
        const std::size_t bits = 8 * size_of(type) - (is_signed ? 1 : 0);
        const std::int64_t greatest = (std::int64_t{1} << bits) - 1;
        const std::int64_t least = is_signed ? -greatest - 1 : 0;
        std::int64_t value = 0;
        const auto word = next(type);
        if (!parse_number(word, value) || value < least || value > greatest)
            wrong(type, word);
        judge_last(value, greatest);
        return value;
    }

    /// In full precision, also where a float is declared: programs write more digits than a float has.
    double real(PlyType type)
    {
        if (is_integer(type))
            return static_cast<double>(integer(type));
        const auto word = next(type);
        double value = 0;
        if (!parse_number(word, value))
            wrong(type, word);
        may_go_on_ = true;
        return value;
    }

    void check_room(const PlyProperty& list, std::size_t items) const
    {
        // Each item takes a separator and a digit.
        if (items > words_.characters_left() / 2)
            fail(fmt::format("the list {} of {} items is longer than its line", in_quotes(list.name), items));
    }

    void skip(PlyType type, std::size_t items)
    {
        for (std::size_t i = 0; i < items; ++i)
            real(type);
        may_go_on_ = false;
    }

    [[noreturn]] void fail(const std::string& what) const { lines_.fail(what); }

  private:
    std::string_view next(PlyType type)
    {
        const auto word = words_.next();
        if (word.empty())
            fail("the line ends; expected a value of type " + std::string(name_of(type)));
        return word;
    }
    [[noreturn]] void wrong(PlyType type, std::string_view word) const
    {
        fail("expected a value of type " + std::string(name_of(type)) + " instead of " + in_quotes(word));
    }

    Lines lines_;
    Words words_;
    bool may_go_on_ = false;  ///< Whether a cut file could have a longer number there.
};

template <class Cursor>
class BodyReader
{
  public:
    BodyReader(Cursor cursor, const PlyHeader& header, const PlyLayout& layout, std::size_t max_triangles, TriangleFan fan,
               std::vector<Vec3d>* positions, MeshMaterials* materials, PlyIntegers* integers)
        : cursor_(std::move(cursor)), header_(header), layout_(layout), max_triangles_(max_triangles), fan_(fan),
          positions_(positions), materials_(materials), integers_(integers),
          colors_faces_(materials != nullptr && layout.face_colors[0] != nullptr && header.pictures.empty() && !layout.has_colors)
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
                skip_rows(element);
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

    std::size_t list_size(const PlyProperty& list)
    {
        const std::int64_t count = cursor_.integer(list.count_type);
        if (count < 0)
            cursor_.fail("the list " + in_quotes(list.name) + " has a negative length");
        cursor_.check_room(list, static_cast<std::size_t>(count));
        return static_cast<std::size_t>(count);
    }

    void skip(const PlyProperty& property) { cursor_.skip(property.type, property.is_list ? list_size(property) : 1); }

    void skip_rows(const PlyElement& element)
    {
        for (std::size_t i = 0; i < element.count; ++i)
        {
            cursor_.begin_row();
            for (const auto& property : element.properties)
                skip(property);
            cursor_.end_row();
        }
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
                    skip(properties[p]);
                else
                {
                    values[slot] = cursor_.real(properties[p].type);
                    if (slot <= slot_z)
                        finite(values[slot], "the coordinate");
                    else if (slot >= slot_u)
                        finite(values[slot], "the texture coordinate");
                    else
                        check_color(values[slot]);
                    if (is_wanted)
                        integers_->of_vertex.push_back(static_cast<std::int64_t>(values[slot]));
                }
            }
            cursor_.end_row();
            const Vec3d position{values[slot_x], values[slot_y], values[slot_z]};
            mesh_.positions.push_back(vec_cast<float>(position));
            if (positions_ != nullptr)
                positions_->push_back(position);
            if (layout_.has_colors && layout_.color_type != PlyType::uint8)
                colors_.push_back(vec_cast<float>(Vec3d{values[slot_red], values[slot_green], values[slot_blue]}));
            else if (layout_.has_colors)
                mesh_.colors.push_back({static_cast<std::uint8_t>(values[slot_red]),
                                        static_cast<std::uint8_t>(values[slot_green]),
                                        static_cast<std::uint8_t>(values[slot_blue])});
            if (layout_.has_vertex_texcoords)
                vertex_texcoords_.push_back({static_cast<float>(values[slot_u]), static_cast<float>(values[slot_v])});
        }
        convert_colors();
    }

    void check_color(double value)
    {
        const int greatest = layout_.color_type == PlyType::uint16 ? 65535 : 255;
        if (!(value >= 0 && value <= greatest))
            cursor_.fail(fmt::format("the color is outside 0 to {}", greatest));
        greatest_color_ = std::max(greatest_color_, value);
    }

    /// Programs write floats to 1 or to 255, and shorts to 255 or to 65535.
    void convert_colors()
    {
        const double one = !is_integer(layout_.color_type) && greatest_color_ <= 1 ? 1 : greatest_color_ > 255 ? 65535 : 255;
        const auto channel = [&](float value) { return static_cast<std::uint8_t>(std::lround(double{value} / one * 255)); };
        for (const Vec3f& color : colors_)
            mesh_.colors.push_back({channel(color.x), channel(color.y), channel(color.z)});
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
            Rgb8 color{};
            for (const auto& property : layout_.face->properties)
            {
                const auto channel = std::ranges::find(layout_.face_colors, &property);
                if (colors_faces_ && channel != layout_.face_colors.end())
                    color[static_cast<std::size_t>(channel - layout_.face_colors.begin())] = face_channel(property);
                else if (&property == layout_.indices)
                    indices();
                else if (&property == layout_.texcoord)
                    texcoords();
                else if (&property == layout_.chart || &property == layout_.picture || &property == layout_.face_integer)
                {
                    const std::int64_t number = cursor_.integer(property.type);
                    if (&property == layout_.chart && number < 0)
                        cursor_.fail(fmt::format("chart {}; expected 0 or more", number));
                    if (&property == layout_.chart)
                        chart = static_cast<std::uint32_t>(number);
                    const auto pictures = static_cast<std::int64_t>(header_.pictures.size());
                    if (&property == layout_.picture && number >= pictures && materials_ != nullptr)
                        cursor_.fail(fmt::format("texnumber {}, but the header names {} pictures ('comment TextureFile NAME')",
                                                 number, pictures));
                    if (&property == layout_.picture)  // -1 stands for none.
                        picture_ = number < 0 ? MeshMaterials::none : static_cast<std::uint32_t>(number);
                    if (&property == layout_.face_integer)
                        integer_ = number;
                }
                else
                    skip(property);
            }
            cursor_.end_row();
            if (colors_faces_)
                picture_ = number_of(color);
            add_face(chart);
        }
    }

    /// Floats go to 1: one face does not tell whether others go to 255.
    std::uint8_t face_channel(const PlyProperty& property)
    {
        const double value = cursor_.real(property.type);
        const int greatest = !is_integer(property.type) ? 1 : property.type == PlyType::uint16 ? 65535 : 255;
        if (!(value >= 0 && value <= greatest))
            cursor_.fail(fmt::format("the color of the face is outside 0 to {}", greatest));
        return static_cast<std::uint8_t>(std::lround(value / greatest * 255));
    }

    /// The index of a color of faces in MeshMaterials::names.
    std::uint32_t number_of(Rgb8 color)
    {
        auto& names = materials_->names;
        const auto [found, is_new] = color_numbers_.try_emplace(color, static_cast<std::uint32_t>(names.size()));
        if (is_new)
            names.push_back({fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]), 0});
        return found->second;
    }

    void indices()
    {
        const std::size_t size = list_size(*layout_.indices);
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
            cursor_.judge_last(index, vertex_count - 1);
        }
    }

    void texcoords()
    {
        const std::size_t size = list_size(*layout_.texcoord);
        if (size % 2 != 0)
            cursor_.fail(fmt::format("the list 'texcoord' has {} items; expected u and v per corner", size));
        corner_texcoords_.resize(size / 2);
        for (auto& uv : corner_texcoords_)
        {
            uv.x = finite(cursor_.real(layout_.texcoord->type), "the texture coordinate");
            uv.y = finite(cursor_.real(layout_.texcoord->type), "the texture coordinate");
        }
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
                       if (colors_faces_ || (layout_.picture != nullptr && materials_ != nullptr))
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
    std::vector<Vec3f> colors_;  ///< As written, unless they are bytes.
    double greatest_color_ = 0;
    std::vector<Vec3d>* positions_;
    MeshMaterials* materials_;
    std::uint32_t picture_ = MeshMaterials::none;
    PlyIntegers* integers_;
    std::int64_t integer_ = 0;
    bool colors_faces_;
    std::map<Rgb8, std::uint32_t> color_numbers_;
};

void check_limits(const PlyLayout& layout, const MeshLimits& limits, std::string_view source)
{
    const auto fail = [&](const PlyElement& element, const std::string& what)
    { throw Error(fmt::format("{}:{}: {}", source, element.line, what)); };
    if (layout.vertex->count > std::min<std::size_t>(limits.max_vertices, UINT32_MAX))
        fail(*layout.vertex, fmt::format("{} vertices; the limit is {}", layout.vertex->count, limits.max_vertices));
    if (layout.face->count > limits.max_faces)
        fail(*layout.face, fmt::format("{} faces; the limit is {}", layout.face->count, limits.max_faces));
    if (layout.face->count == 0)
        fail(*layout.face, "the file holds no faces; export the scan as a triangle mesh, not as points");
}

}  // namespace

Mesh detail::parse_ply_faces(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits,
                             MeshReadReport* report, bool keeps_degenerate, MeshMaterials* materials, PlyIntegers* integers)
{
    const PlyHeader header = parse_ply_header(bytes, source);
    const PlyLayout layout = ply_layout(header, source, integers != nullptr ? &integers->property : nullptr);
    check_limits(layout, limits, source);

    MeshReadReport counted;
    const TriangleFan fan(counted, keeps_degenerate);
    const auto read = [&](auto cursor)
    {
        auto* const positions = keeps_degenerate ? nullptr : &counted.positions;
        return BodyReader(std::move(cursor), header, layout, limits.max_faces, fan, positions, materials, integers).read();
    };
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
    if (header.offset_m != Vec3d{})
        for (Vec3d& position : counted.positions)
            position += header.offset_m;
    if (keeps_degenerate)
        mesh.offset_m = header.offset_m;
    else
        place(mesh, counted.positions, offset_for(counted.positions));
    if (report != nullptr)
        *report = std::move(counted);
    if (materials != nullptr)
        materials->files = header.pictures;
    return mesh;
}

Mesh parse_ply(std::span<const std::byte> bytes, std::string_view source, const MeshLimits& limits, MeshReadReport* report,
               MeshMaterials* materials, PlyIntegers* integers)
{
    if (materials != nullptr)
        *materials = {};
    if (integers != nullptr)
        *integers = {.property = integers->property, .of_vertex = {}, .of_face = {}};
    return detail::parse_ply_faces(bytes, source, limits, report, false, materials, integers);
}

namespace
{

std::string header_of(const Mesh& mesh)
{
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    if (!mesh.texcoords.empty() && mesh.texture_px > 0)
        text += fmt::format("comment texture_px {}\n", mesh.texture_px);
    if (mesh.offset_m != Vec3d{})
        text += fmt::format("comment offset_m {} {} {}\n", mesh.offset_m.x, mesh.offset_m.y, mesh.offset_m.z);
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

    std::byte* next = bytes.data() + header.size();
    const auto put = [&next](auto value)
    {
        auto raw = std::bit_cast<std::array<std::byte, sizeof value>>(value);
        if constexpr (std::endian::native == std::endian::big)
            std::reverse(raw.begin(), raw.end());
        std::memcpy(next, raw.data(), raw.size());
        next += raw.size();
    };
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        put(mesh.positions[i].x);
        put(mesh.positions[i].y);
        put(mesh.positions[i].z);
        if (!mesh.colors.empty())
            for (const std::uint8_t channel : mesh.colors[i])
                put(channel);
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        put(std::uint8_t{3});
        for (const std::uint32_t corner : mesh.triangles[i])
            put(corner);
        if (!mesh.texcoords.empty())
        {
            put(std::uint8_t{6});
            for (std::size_t corner = 3 * i; corner < 3 * i + 3; ++corner)
            {
                put(mesh.texcoords[corner].x);
                put(mesh.texcoords[corner].y);
            }
        }
        if (!mesh.charts.empty())
            put(mesh.charts[i]);
    }
    return bytes;
}

}  // namespace fresco
