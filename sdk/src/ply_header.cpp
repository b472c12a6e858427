#include "ply_header.h"
#include "mesh_text.h"

#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <initializer_list>
#include <utility>

namespace fresco::detail
{
namespace
{

// A header is a few hundred bytes; this bounds the search for its end in a file that is no PLY.
constexpr std::size_t max_header_bytes = std::size_t{1} << 20U;
constexpr int largest_texture_px = 262144;
// Every name is compared with those before it.
constexpr std::size_t most_elements = 256;
constexpr std::size_t most_properties = 1024;

/// In the order of PlyType: each type's plain and its sized name.
constexpr std::array<std::string_view, 16> type_names{"char",   "int8",    "uchar",  "uint8",  "short", "int16",
                                                      "ushort", "uint16",  "int",    "int32",  "uint",  "uint32",
                                                      "float",  "float32", "double", "float64"};
/// In the order of PlyFormat.
constexpr std::array<std::string_view, 3> format_names{"ascii", "binary_little_endian", "binary_big_endian"};

class HeaderReader
{
  public:
    HeaderReader(std::span<const std::byte> bytes, std::string_view source)
        : text_(as_text(bytes)), lines_(text_.substr(0, std::min(text_.size(), max_header_bytes)), source)
    {
    }

    PlyHeader read()
    {
        if (!text_.starts_with("ply\n") && !text_.starts_with("ply\r\n"))
            lines_.fail_at(1, "expected the line 'ply': not a PLY file, or truncated");
        lines_.next(line_);
        if (next_statement() != "format")
            lines_.fail("expected 'format ascii 1.0', 'format binary_little_endian 1.0' or 'format binary_big_endian 1.0'");
        format();
        for (std::string_view word = next_statement(); word != "end_header"; word = next_statement())
        {
            if (word == "element")
                element();
            else if (word == "property")
                property();
            else
                lines_.fail("expected element, property, comment, obj_info or end_header instead of " + in_quotes(word));
        }
        end_of_line();
        header_.lines = lines_.number();
        header_.body_offset = lines_.offset();
        check_counts();
        return std::move(header_);
    }

  private:
    /// The first word of the next line that is no comment; words_ stands behind it.
    std::string_view next_statement()
    {
        while (lines_.next(line_))
        {
            words_ = Words(line_);
            const std::string_view word = words_.next();
            if (word != "comment" && word != "obj_info")
                return word;
            const std::string_view about = words_.next();
            if (about == "TextureFile")
                header_.pictures.push_back({std::string(words_.rest()), lines_.number()});
            else
                header_.comments.emplace_back(line_);
            if (about == "texture_px")
                texture_px();
            else if (about == "offset_m")
                offset();
        }
        lines_.fail("the file ends before 'end_header': it is cut; copy or export it again");
    }

    void texture_px()
    {
        const std::string_view word = words_.next();
        if (!parse_number(word, header_.texture_px) || header_.texture_px < 1 || header_.texture_px > largest_texture_px)
            lines_.fail(
                fmt::format("expected 'comment texture_px' and 1 to {} instead of {}", largest_texture_px, in_quotes(word)));
    }

    void offset()
    {
        for (const auto axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z})
            if (!parse_number(words_.next(), header_.offset_m.*axis) || !std::isfinite(header_.offset_m.*axis))
                lines_.fail("expected 'comment offset_m' and three numbers, in meters");
    }

    void end_of_line()
    {
        if (const auto word = words_.next(); !word.empty())
            lines_.fail("unexpected " + in_quotes(word) + " at the end of the line");
    }

    void format()
    {
        const auto name = words_.next();
        const auto known = std::ranges::find(format_names, name);
        if (known == format_names.end())
            lines_.fail("unknown format " + in_quotes(name) + "; expected ascii, binary_little_endian or binary_big_endian");
        header_.format = static_cast<PlyFormat>(known - format_names.begin());
        if (const auto version = words_.next(); version != "1.0")
            lines_.fail("unknown format version " + in_quotes(version) + "; expected 1.0");
        end_of_line();
    }

    void element()
    {
        PlyElement element;
        element.name = words_.next();
        element.line = lines_.number();
        if (element.name.empty())
            lines_.fail("expected 'element NAME COUNT'");
        if (std::ranges::find(header_.elements, element.name, &PlyElement::name) != header_.elements.end())
            lines_.fail("a second element " + in_quotes(element.name));
        if (const auto count = words_.next(); !parse_number(count, element.count))
            lines_.fail("expected the number of " + in_quotes(element.name) + " elements instead of " + in_quotes(count));
        end_of_line();
        if (header_.elements.size() == most_elements)
            lines_.fail(fmt::format("more than {} elements: this is not a mesh", most_elements));
        header_.elements.push_back(std::move(element));
    }

    PlyType type(std::string_view word) const
    {
        const auto known = std::ranges::find(type_names, word);
        if (known != type_names.end())
            return static_cast<PlyType>((known - type_names.begin()) / 2);
        lines_.fail("unknown type " + in_quotes(word) + "; expected char, uchar, short, ushort, int, uint, float or double");
    }

    void property()
    {
        if (header_.elements.empty())
            lines_.fail("a property before the first element");
        PlyProperty property;
        property.line = line_;
        std::string_view word = words_.next();
        property.is_list = word == "list";
        if (property.is_list)
        {
            property.count_type = type(words_.next());
            if (!is_integer(property.count_type))
                lines_.fail("a list's count must be of an integer type");
            word = words_.next();
        }
        property.type = type(word);
        property.name = words_.next();
        if (property.name.empty())
            lines_.fail("expected a property's name at the end of the line");
        end_of_line();
        auto& properties = header_.elements.back().properties;
        if (std::ranges::find(properties, property.name, &PlyProperty::name) != properties.end())
            lines_.fail("a second property " + in_quotes(property.name) + " of element " +
                        in_quotes(header_.elements.back().name));
        if (properties.size() == most_properties)
            lines_.fail(fmt::format("more than {} properties of one element: this is not a mesh", most_properties));
        properties.push_back(std::move(property));
    }

    /// Bytes that one row of an element takes at least. In text: a digit and a separator per value.
    std::size_t least_row_bytes(const PlyElement& element) const
    {
        const bool ascii = header_.format == PlyFormat::ascii;
        std::size_t bytes = 0;
        for (const auto& property : element.properties)
        {
            const std::size_t items = !property.is_list ? 1 : is_index_list(element, property) ? least_corners : 0;
            if (property.is_list)
                bytes += ascii ? 2 : size_of(property.count_type);
            bytes += items * (ascii ? 2 : size_of(property.type));
        }
        return bytes;
    }

    void check_counts() const
    {
        std::size_t left = text_.size() - header_.body_offset;
        // The last line of a text may lack its end.
        const std::size_t missing = header_.format == PlyFormat::ascii ? 1 : 0;
        for (const auto& element : header_.elements)
        {
            if (element.count == 0)
                continue;
            const std::size_t row = least_row_bytes(element);
            if (row == 0)
                lines_.fail_at(element.line, "element " + in_quotes(element.name) + " has no properties");
            if (element.count > (left + missing) / row)
                lines_.fail_at(element.line, fmt::format("{} elements {} of at least {} bytes each do not fit into the {} bytes "
                                                         "that are left: the file is cut, or the count is wrong",
                                                         element.count, in_quotes(element.name), row, left));
            left -= std::min(left, element.count * row);
        }
    }

    std::string_view text_;
    Lines lines_;
    std::string_view line_;
    Words words_;
    PlyHeader header_;
};

}  // namespace
}  // namespace fresco::detail

namespace fresco
{

std::string_view name_of(PlyType type)
{
    return detail::type_names[2 * static_cast<std::size_t>(type)];
}

bool is_index_list(const PlyElement& element, const PlyProperty& property)
{
    return element.name == "face" && property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

PlyHeader parse_ply_header(std::span<const std::byte> bytes, std::string_view source)
{
    return detail::HeaderReader(bytes, source).read();
}

}  // namespace fresco

namespace fresco::detail
{
namespace
{

constexpr std::array<std::pair<std::string_view, std::string_view>, 4> texcoord_names{
    {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};

constexpr std::array<std::array<std::string_view, 3>, 3> color_names{
    {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}}};

class LayoutReader
{
  public:
    LayoutReader(const PlyHeader& header, std::string_view source) : header_(header), source_(source) {}

    PlyLayout read(const std::string* integer)
    {
        layout_.vertex = &element("vertex");
        if (std::ranges::any_of(header_.elements, [](const auto& each) { return each.name == "tristrips" && each.count > 0; }))
            fail("the file has triangle strips ('tristrips'), which are not read; save it with faces, for example by MeshLab");
        layout_.face = &element("face");
        vertex();
        face();
        if (integer != nullptr)
            integers(*integer);
        return std::move(layout_);
    }

  private:
    [[noreturn]] void fail(const std::string& what) const { throw Error(std::string(source_) + ": header: " + what); }

    const PlyElement& element(std::string_view name) const
    {
        const auto found = std::ranges::find(header_.elements, name, &PlyElement::name);
        if (found == header_.elements.end())
            fail("missing element " + in_quotes(name) + "; export the scan as a triangle mesh");
        return *found;
    }

    static const PlyProperty* find(const PlyElement& element, std::string_view name)
    {
        const auto found = std::ranges::find(element.properties, name, &PlyProperty::name);
        return found == element.properties.end() ? nullptr : &*found;
    }

    static bool is_number(const PlyProperty* property)
    {
        return property != nullptr && !property->is_list && is_integer(property->type);
    }

    void integers(const std::string& name)
    {
        std::vector<std::string> there;
        const auto integer = [&](const PlyElement& element)
        {
            for (const auto& property : element.properties)
                if (is_number(&property))
                    there.push_back(property.name);
            const PlyProperty* const found = find(element, name);
            return is_number(found) ? found : nullptr;
        };
        layout_.vertex_integer = integer(*layout_.vertex);
        layout_.face_integer = integer(*layout_.face);
        if (layout_.vertex_integer == nullptr && layout_.face_integer == nullptr)
            fail("neither vertices nor faces have an integer property " + in_quotes(name) + suggestion(name, there));
    }

    void vertex()
    {
        const PlyElement& vertex = *layout_.vertex;
        layout_.slots.assign(vertex.properties.size(), slot_none);
        if (!take(slot_x, {"x", "y", "z"}))
            fail("element 'vertex' has no properties x, y, z");
        // A property 'r' without 'g' is not a color.
        layout_.has_colors = std::ranges::any_of(
            color_names,
            [&](const auto& names) {
                return (names[0] == "red" || find(vertex, names[1])) && take(slot_red, {names[0], names[1], names[2]});
            });
        layout_.has_vertex_texcoords = std::ranges::any_of(texcoord_names,
                                                           [&](const auto& names) {
                                                               return take(slot_u, {names.first, names.second});
                                                           });
    }

    /// Gives the named properties to the slots from `first` on: all of them or none.
    bool take(VertexSlot first, std::initializer_list<std::string_view> names)
    {
        if (std::ranges::none_of(names, [&](auto name) { return find(*layout_.vertex, name) != nullptr; }))
            return false;
        std::size_t slot = first;
        for (const auto name : names)
        {
            const PlyProperty* const property = find(*layout_.vertex, name);
            if (property == nullptr)
                fail("the vertex property " + in_quotes(name) + " is missing, though others of its group are there");
            if (slot == slot_red)
                layout_.color_type = property->type;
            const bool fits =
                first == slot_red ? property->type == layout_.color_type : first == slot_x || !is_integer(property->type);
            if (property->is_list || !fits)
                fail("the vertex property " + in_quotes(name) + " must be " +
                     (first == slot_red ? "a number of the type of the other colors"
                      : first == slot_x ? "a number"
                                        : "of type float or double"));
            layout_.slots[static_cast<std::size_t>(property - layout_.vertex->properties.data())] =
                static_cast<VertexSlot>(slot++);
        }
        return true;
    }

    void face()
    {
        const PlyElement& face = *layout_.face;
        for (const auto& names : color_names)
            if (const auto* const red = find(face, names[0]); red != nullptr && !layout_.face_colors[0])
                layout_.face_colors = {red, find(face, names[1]), find(face, names[2])};
        if (!std::ranges::all_of(layout_.face_colors, [](const auto* each) { return each != nullptr && !each->is_list; }))
            layout_.face_colors = {};
        for (const auto& property : layout_.face->properties)
        {
            const auto need = [&](bool fits, const char* what)
            {
                if (!fits)
                    fail("the face property " + in_quotes(property.name) + " must be " + what);
            };
            if (is_index_list(*layout_.face, property))
            {
                if (layout_.indices != nullptr)
                    fail("element " + in_quotes(layout_.face->name) + " has both vertex_indices and vertex_index");
                need(is_integer(property.type), "a list of an integer type");
                layout_.indices = &property;
            }
            else if (property.name == "texcoord")
            {
                need(property.is_list && !is_integer(property.type), "a list of float or double");
                layout_.texcoord = &property;
            }
            else if (property.name == "chart")
            {
                need(is_number(&property), "of an integer type");
                layout_.chart = &property;
            }
            else if (property.name == "texnumber" && is_number(&property))
                layout_.picture = &property;
        }
        if (layout_.indices == nullptr)
            fail("element " + in_quotes(layout_.face->name) + " has no list vertex_indices");
    }

    const PlyHeader& header_;
    std::string_view source_;
    PlyLayout layout_;
};

}  // namespace

PlyLayout ply_layout(const PlyHeader& header, std::string_view source, const std::string* integer)
{
    return LayoutReader(header, source).read(integer);
}

}  // namespace fresco::detail
