#include "ply_header.h"
#include "mesh_text.h"
#include "ply_cursor.h"

#include <fresco/wording.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <initializer_list>
#include <optional>
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

constexpr std::array<std::pair<std::string_view, PlyType>, 16> type_names{{{"char", PlyType::int8},
                                                                           {"int8", PlyType::int8},
                                                                           {"uchar", PlyType::uint8},
                                                                           {"uint8", PlyType::uint8},
                                                                           {"short", PlyType::int16},
                                                                           {"int16", PlyType::int16},
                                                                           {"ushort", PlyType::uint16},
                                                                           {"uint16", PlyType::uint16},
                                                                           {"int", PlyType::int32},
                                                                           {"int32", PlyType::int32},
                                                                           {"uint", PlyType::uint32},
                                                                           {"uint32", PlyType::uint32},
                                                                           {"float", PlyType::float32},
                                                                           {"float32", PlyType::float32},
                                                                           {"double", PlyType::float64},
                                                                           {"float64", PlyType::float64}}};

class HeaderReader
{
  public:
    HeaderReader(std::span<const std::byte> bytes, std::string_view source)
        : text_(as_text(bytes)), lines_(text_.substr(0, std::min(text_.size(), max_header_bytes)), source)
    {
    }

    PlyHeader read()
    {
        std::string_view line;
        if (!text_.starts_with("ply\n") && !text_.starts_with("ply\r\n"))
            lines_.fail_at(1, "expected the line 'ply': not a PLY file, or truncated");
        lines_.next(line);
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
        std::string_view line;
        while (lines_.next(line))
        {
            words_ = Words(line);
            const std::string_view word = words_.next();
            if (word != "comment" && word != "obj_info")
                return word;
            const std::string_view about = words_.next();
            if (about == "TextureFile")
                header_.pictures.push_back({words_.rest(), lines_.number()});
            else if (about == "texture_px")
                texture_px();
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

    void end_of_line()
    {
        if (const auto word = words_.next(); !word.empty())
            lines_.fail("unexpected " + in_quotes(word) + " at the end of the line");
    }

    void format()
    {
        const auto name = words_.next();
        if (name == "ascii")
            header_.format = PlyFormat::ascii;
        else if (name == "binary_little_endian")
            header_.format = PlyFormat::little_endian;
        else if (name == "binary_big_endian")
            header_.format = PlyFormat::big_endian;
        else
            lines_.fail("unknown format " + in_quotes(name) + "; expected ascii, binary_little_endian or binary_big_endian");
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
        for (const auto& other : header_.elements)
            if (other.name == element.name)
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
        for (const auto& [name, type] : type_names)
            if (name == word)
                return type;
        lines_.fail("unknown type " + in_quotes(word) + "; expected char, uchar, short, ushort, int, uint, float or double");
    }

    void property()
    {
        if (header_.elements.empty())
            lines_.fail("a property before the first element");
        PlyProperty property;
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
        for (const auto& other : properties)
            if (other.name == property.name)
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
        for (const auto& element : header_.elements)
        {
            if (element.count == 0)
                continue;
            const std::size_t row = least_row_bytes(element);
            if (row == 0)
                lines_.fail_at(element.line, "element " + in_quotes(element.name) + " has no properties");
            if (element.count > left / row)
                lines_.fail_at(element.line, fmt::format("{} elements {} of at least {} bytes each do not fit into the {} bytes "
                                                         "that are left: the file is cut, or the count is wrong",
                                                         element.count, in_quotes(element.name), row, left));
            left -= element.count * row;
        }
    }

    std::string_view text_;
    Lines lines_;
    Words words_;
    PlyHeader header_;
};

}  // namespace

std::string_view name_of(PlyType type)
{
    // The plain names are at even places.
    return type_names[static_cast<std::size_t>(type) * 2].first;
}

bool is_index_list(const PlyElement& element, const PlyProperty& property)
{
    return element.name == "face" && property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

PlyHeader parse_ply_header(std::span<const std::byte> bytes, std::string_view source)
{
    return HeaderReader(bytes, source).read();
}
namespace
{

constexpr std::array<std::pair<std::string_view, std::string_view>, 4> texcoord_names{
    {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};

class LayoutReader
{
  public:
    LayoutReader(const PlyHeader& header, std::string_view source) : header_(header), source_(source) {}

    void find_integers(PlyLayout& layout, const std::string& name) const
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

    PlyLayout read()
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
    PlyLayout layout_;
};

}  // namespace

PlyLayout ply_layout(const PlyHeader& header, std::string_view source, const std::string* integer)
{
    LayoutReader reader(header, source);
    PlyLayout layout = reader.read();
    if (integer != nullptr)
        reader.find_integers(layout, *integer);
    return layout;
}

}  // namespace fresco::detail
