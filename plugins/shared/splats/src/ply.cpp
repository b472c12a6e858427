#include "formats.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <system_error>

namespace fresco::splats
{
namespace
{

std::size_t size_of(std::string_view type)
{
    static const std::map<std::string_view, std::size_t> sizes{
        {"char", 1}, {"int8", 1},  {"uchar", 1}, {"uint8", 1},  {"short", 2}, {"int16", 2},   {"ushort", 2}, {"uint16", 2},
        {"int", 4},  {"int32", 4}, {"uint", 4},  {"uint32", 4}, {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    const auto found = sizes.find(type);
    return found == sizes.end() ? 0 : found->second;
}

std::vector<std::string_view> words_of(std::string_view line)
{
    constexpr std::string_view spaces = " \t\r";
    std::vector<std::string_view> words;
    for (std::size_t begin = line.find_first_not_of(spaces); begin < line.size(); begin = line.find_first_not_of(spaces, begin))
    {
        const std::size_t end = std::min(line.find_first_of(spaces, begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = end;
    }
    return words;
}

/// Places the elements behind the header, up to the last one that is read.
void place(PlyLayout& layout, std::size_t header_bytes, Bytes bytes, const std::string& source)
{
    std::size_t begin = header_bytes;
    if (std::ranges::find(layout.elements, "vertex", &PlyLayout::Element::name) == layout.elements.end())
        return;
    for (auto& element : layout.elements)
    {
        element.begin = begin;
        if (element.row_bytes == 0)
            throw Error(
                fmt::format("{}: the element \"{}\" has lists or no properties and stands before the vertices; splats have "
                            "their vertices before such an element",
                            source, element.name));
        const std::size_t rows = (bytes.size() - begin) / element.row_bytes;
        if (element.count > rows)
            fail_at(source, bytes.size(),
                    fmt::format("the file ends behind {} of the {} rows of \"{}\"; it is cut short: copy or download it again",
                                rows, element.count, element.name));
        begin += element.count * element.row_bytes;
        if (element.name == "vertex")
            return;
    }
}

}  // namespace

const PlyLayout::Property* PlyLayout::Element::find(std::string_view property) const
{
    const auto found = std::ranges::find(properties, property, &Property::name);
    return found == properties.end() ? nullptr : &*found;
}

std::size_t PlyLayout::Element::offset_of(std::string_view property, std::string_view type, const std::string& source) const
{
    const Property* const found = find(property);
    if (found == nullptr || (found->type != type && found->type != std::string(type) + "32"))
        throw Error(
            fmt::format("{}: its header lacks \"property {} {}\", which Gaussian splats have; a mesh is read by scan.mesh",
                        source, type, property));
    return found->offset;
}

const PlyLayout::Element* PlyLayout::find(std::string_view name) const
{
    const auto found = std::ranges::find(elements, name, &Element::name);
    return found == elements.end() || found->row_bytes == 0 ? nullptr : &*found;
}

PlyLayout ply_layout(Bytes bytes, const std::string& source)
{
    constexpr std::size_t longest_header = std::size_t{1} << 20U;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), longest_header));
    PlyLayout layout;
    bool has_list = false;
    std::size_t begin = 0;
    for (std::size_t line = 1;; ++line)
    {
        const auto fail = [&](const std::string& what) { throw Error(fmt::format("{}: line {}: {}", source, line, what)); };
        const std::size_t end = text.find('\n', begin);
        if (end == std::string_view::npos)
            fail("the PLY header does not end");
        const auto words = words_of(text.substr(begin, end - begin));
        begin = end + 1;
        const std::string_view first = words.empty() ? "comment" : words[0];
        if (first == "end_header")
            break;
        if (first == "format" && (words.size() < 2 || words[1] != "binary_little_endian"))
            fail("expected \"format binary_little_endian 1.0\", as all programs write Gaussian splats");
        else if (first == "element")
        {
            PlyLayout::Element element;
            const bool is_whole = words.size() == 3;
            const char* const digits_end = is_whole ? words[2].data() + words[2].size() : nullptr;
            const auto read = is_whole ? std::from_chars(words[2].data(), digits_end, element.count) : std::from_chars_result{};
            if (!is_whole || read.ec != std::errc() || read.ptr != digits_end)
                fail("expected \"element NAME COUNT\"");
            element.name = words[1];
            layout.elements.push_back(std::move(element));
            has_list = false;
        }
        else if (first == "property")
        {
            const bool is_list = words.size() == 5 && words[1] == "list";
            if (layout.elements.empty() || (!is_list && (words.size() != 3 || size_of(words[1]) == 0)))
                fail("expected \"property TYPE NAME\" behind an element");
            auto& element = layout.elements.back();
            has_list = has_list || is_list;
            element.properties.push_back({std::string(words.back()), std::string(words[1]), element.row_bytes});
            element.row_bytes = has_list ? 0 : element.row_bytes + size_of(words[1]);
        }
    }
    place(layout, begin, bytes, source);
    return layout;
}

SplatFile parse_ply(Bytes bytes, const std::string& source)
{
    const PlyLayout layout = ply_layout(bytes, source);
    if (layout.find("chunk") != nullptr)
        return parse_compressed_ply(bytes, layout, source);
    const PlyLayout::Element* const vertex = layout.find("vertex");
    if (vertex == nullptr || vertex->count == 0)
        throw Error(source + ": has no vertices, and so no Gaussian splats");
    const auto offset = [&](const char* name) { return vertex->offset_of(name, "float", source); };
    const auto three = [&](const char* a, const char* b, const char* c) {
        return std::array<std::size_t, 3>{offset(a), offset(b), offset(c)};
    };
    const auto center = three("x", "y", "z");
    const auto dc = three("f_dc_0", "f_dc_1", "f_dc_2");
    const auto scale = three("scale_0", "scale_1", "scale_2");
    const auto turn = three("rot_1", "rot_2", "rot_3");
    const std::size_t turn_w = offset("rot_0");
    const std::size_t opacity = offset("opacity");

    SplatFile file;
    file.format = SplatFormat::ply;
    const auto rest = static_cast<std::size_t>(
        std::ranges::count_if(vertex->properties, [](const auto& p) { return p.name.starts_with("f_rest_"); }));
    int degree = 0;
    while (3 * coefficients_of(degree) < rest)
        ++degree;
    if (3 * coefficients_of(degree) != rest || degree > 4)
        throw Error(fmt::format("{}: its header has {} properties f_rest_*; expected 0, 9, 24, 45 or 72, for spherical harmonics "
                                "of degree 0 to 4",
                                source, rest));
    resize(file.splats, vertex->count);
    for (std::size_t i = 0; i < vertex->count; ++i)
    {
        const Bytes row = bytes.subspan(vertex->begin + i * vertex->row_bytes, vertex->row_bytes);
        const auto number = [&](std::size_t at) { return value_at<float>(row, at); };
        const auto vector = [&](const std::array<std::size_t, 3>& at) {
            return Vec3f{number(at[0]), number(at[1]), number(at[2])};
        };
        const Vec3d color = vec_cast<double>(vector(dc)) * harmonic_0 + Vec3d{0.5, 0.5, 0.5};
        const Vec3f turned = vector(turn);
        set(file.splats, i, vector(center), {number(turn_w), turned.x, turned.y, turned.z}, vec_cast<double>(vector(scale)),
            sigmoid(number(opacity)), vec_cast<float>(color), source);
    }
    return file;
}

}  // namespace fresco::splats
