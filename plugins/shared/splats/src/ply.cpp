#include "formats.h"

#include <algorithm>

namespace fresco::splats
{

std::size_t PlyRows::offset_of(std::string_view property, PlyType type, const std::string& source) const
{
    std::size_t offset = 0;
    for (const PlyProperty& each : properties)
    {
        if (each.name == property && each.type == type)
            return offset;
        offset += size_of(each.type);
    }
    throw Error(fmt::format("{}: its header lacks \"property {} {}\", which Gaussian splats have; a mesh is read by scan.mesh",
                            source, fresco::name_of(type), property));
}

const PlyRows* find_rows(const std::vector<PlyRows>& elements, std::string_view name)
{
    const auto found = std::ranges::find(elements, name, &PlyRows::name);
    return found == elements.end() ? nullptr : &*found;
}

std::array<std::size_t, 14> gaussian_offsets(const PlyRows& vertex, const std::string& source)
{
    std::array<std::size_t, 14> offsets{};
    for (std::size_t k = 0; k < offsets.size(); ++k)
        offsets[k] = vertex.offset_of(gaussian_names[k], PlyType::float32, source);
    return offsets;
}

std::vector<PlyRows> ply_rows(Bytes bytes, const std::string& source)
{
    const PlyHeader header = parse_ply_header(bytes, source);
    if (header.format != PlyFormat::little_endian)
        throw Error(source + ": expected \"format binary_little_endian 1.0\", as all programs write Gaussian splats");
    std::vector<PlyRows> elements;
    std::size_t begin = header.body_offset;
    for (const PlyElement& declared : header.elements)
    {
        const bool has_list = std::ranges::any_of(declared.properties, &PlyProperty::is_list);
        // Elements behind the vertices are not read.
        if (has_list && find_rows(elements, "vertex") != nullptr)
            break;
        if (has_list)
            throw Error(fmt::format("{}: the element \"{}\" has lists and stands before the vertices; splats have their vertices "
                                    "before such an element",
                                    source, declared.name));
        PlyRows rows{declared, begin};
        for (const PlyProperty& property : declared.properties)
            rows.row_bytes += size_of(property.type);
        begin += rows.count * rows.row_bytes;
        elements.push_back(std::move(rows));
    }
    return elements;
}

SplatFile parse_ply(Bytes bytes, const std::string& source)
{
    const auto elements = ply_rows(bytes, source);
    const PlyRows* const vertex = find_rows(elements, "vertex");
    if (vertex == nullptr || vertex->count == 0)
        throw Error(source + ": has no vertices, and so no Gaussian splats");
    if (const PlyRows* const chunk = find_rows(elements, "chunk"))
        return parse_compressed_ply(bytes, *chunk, *vertex, source);
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
