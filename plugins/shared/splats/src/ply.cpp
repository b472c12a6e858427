#include "formats.h"

#include <algorithm>

namespace fresco::splats
{

const PlyLayout::Property* PlyLayout::Element::find(std::string_view property) const
{
    const auto found = std::ranges::find(properties, property, &Property::name);
    return found == properties.end() ? nullptr : &*found;
}

std::size_t PlyLayout::Element::offset_of(std::string_view property, PlyType type, const std::string& source) const
{
    const Property* const found = find(property);
    if (found == nullptr || found->type != type)
        throw Error(
            fmt::format("{}: its header lacks \"property {} {}\", which Gaussian splats have; a mesh is read by scan.mesh",
                        source, fresco::name_of(type), property));
    return found->offset;
}

const PlyLayout::Element* PlyLayout::find(std::string_view name) const
{
    const auto found = std::ranges::find(elements, name, &Element::name);
    return found == elements.end() ? nullptr : &*found;
}

std::array<std::size_t, 14> gaussian_offsets(const PlyLayout::Element& vertex, const std::string& source)
{
    std::array<std::size_t, 14> offsets{};
    for (std::size_t k = 0; k < offsets.size(); ++k)
        offsets[k] = vertex.offset_of(gaussian_names[k], PlyType::float32, source);
    return offsets;
}

PlyLayout ply_layout(Bytes bytes, const std::string& source)
{
    const PlyHeader header = parse_ply_header(bytes, source);
    if (header.format != PlyFormat::little_endian)
        throw Error(source + ": expected \"format binary_little_endian 1.0\", as all programs write Gaussian splats");
    PlyLayout layout;
    std::size_t begin = header.body_offset;
    for (const PlyElement& declared : header.elements)
    {
        PlyLayout::Element element{.name = declared.name, .count = declared.count, .properties = {}, .begin = begin};
        for (const PlyProperty& property : declared.properties)
        {
            // Elements behind the vertices are not read.
            if (property.is_list && layout.find("vertex") != nullptr)
                return layout;
            if (property.is_list)
                throw Error(fmt::format("{}: the element \"{}\" has lists and stands before the vertices; splats have their "
                                        "vertices before such an element",
                                        source, declared.name));
            element.properties.push_back({property.name, property.type, element.row_bytes});
            element.row_bytes += size_of(property.type);
        }
        begin += element.count * element.row_bytes;
        layout.elements.push_back(std::move(element));
    }
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
    const auto offsets = gaussian_offsets(*vertex, source);

    SplatFile file;
    file.format = SplatFormat::ply;
    const auto rest = static_cast<std::size_t>(
        std::ranges::count_if(vertex->properties, [](const auto& p) { return p.name.starts_with("f_rest_"); }));
    if (std::ranges::none_of(std::array{0, 1, 2, 3, 4}, [&](int degree) { return 3 * coefficients_of(degree) == rest; }))
        throw Error(fmt::format("{}: its header has {} properties f_rest_*; expected 0, 9, 24, 45 or 72, for spherical harmonics "
                                "of degree 0 to 4",
                                source, rest));
    resize(file.splats, vertex->count);
    for (std::size_t i = 0; i < vertex->count; ++i)
    {
        const Bytes row = bytes.subspan(vertex->begin + i * vertex->row_bytes, vertex->row_bytes);
        std::array<float, gaussian_names.size()> number{};
        for (std::size_t k = 0; k < number.size(); ++k)
            number[k] = value_at<float>(row, offsets[k]);
        const Vec3d color = Vec3d{number[3], number[4], number[5]} * harmonic_0 + Vec3d{0.5, 0.5, 0.5};
        set(file.splats, i, {number[0], number[1], number[2]}, {number[10], number[11], number[12], number[13]},
            {number[7], number[8], number[9]}, sigmoid(number[6]), vec_cast<float>(color), source);
    }
    return file;
}

}  // namespace fresco::splats
