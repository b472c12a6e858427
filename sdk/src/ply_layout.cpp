#include "ply_layout.h"

#include "ply_cursor.h"

#include <fresco/wording.h>

#include <array>
#include <initializer_list>
#include <optional>
#include <utility>

namespace fresco::detail
{
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
