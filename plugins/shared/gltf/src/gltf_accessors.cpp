#include <fresco/gltf/gltf_accessors.h>

#include <fresco/gltf/gltf_file.h>

#include <fresco/error.h>

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <numeric>

namespace fresco::gltf
{

namespace
{

template <class T>
double read_number(const unsigned char* from, double greatest)
{
    T value{};
    std::memcpy(&value, from, sizeof value);
    return greatest > 0 ? std::max(static_cast<double>(value) / greatest, -1.0) : static_cast<double>(value);
}

std::size_t size_of_component(int type)
{
    const bool is_known = type == TINYGLTF_COMPONENT_TYPE_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                          type == TINYGLTF_COMPONENT_TYPE_SHORT || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                          type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    return is_known ? static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type))) : 0;
}

}  // namespace

double AccessorRows::at(std::size_t row, std::size_t component) const
{
    const unsigned char* const from = first + row * stride + component * size_of_component(component_type);
    switch (component_type)
    {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return read_number<std::int8_t>(from, normalized ? 127 : 0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return read_number<std::uint8_t>(from, normalized ? 255 : 0);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return read_number<std::int16_t>(from, normalized ? 32767 : 0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return read_number<std::uint16_t>(from, normalized ? 65535 : 0);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return read_number<std::uint32_t>(from, 0);
    default:
        return read_number<float>(from, 0);
    }
}

std::uint32_t AccessorRows::integer_at(std::size_t row) const
{
    return static_cast<std::uint32_t>(at(row, 0));
}

AccessorRows accessor_rows(const tinygltf::Model& model, int accessor, std::size_t least, std::size_t most)
{
    if (accessor < 0 || static_cast<std::size_t>(accessor) >= model.accessors.size())
        throw Error(fmt::format("accessor {} of {}", accessor, model.accessors.size()));
    const auto number = static_cast<std::size_t>(accessor);
    const auto& source = model.accessors[number];
    const auto expect = [&](bool good, const std::string& what)
    {
        if (!good)
            throw Error(entry("accessors", number) + what);
    };
    expect(!source.sparse.isSparse, "sparse accessors are not supported; export the model without them");
    expect(source.bufferView >= 0 && static_cast<std::size_t>(source.bufferView) < model.bufferViews.size(),
           "it has no valid bufferView, so no data (the model may be compressed: export it without compression)");
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(source.type));
    AccessorRows rows;
    rows.components = static_cast<std::size_t>(std::max(components, 0));
    expect(rows.components >= least && rows.components <= most && source.type != TINYGLTF_TYPE_MAT2,
           fmt::format("expected {} to {} components", least, most));
    rows.component_type = source.componentType;
    const std::size_t packed = rows.components * size_of_component(source.componentType);
    expect(packed > 0, fmt::format("componentType {} is not supported", source.componentType));
    rows.normalized = source.normalized;
    rows.count = source.count;
    const auto view_number = static_cast<std::size_t>(source.bufferView);
    const std::size_t stride = model.bufferViews[view_number].byteStride;
    rows.stride = stride == 0 ? packed : stride;
    const auto bytes = view_bytes(model, view_number);
    const bool fits = rows.count > 0 && rows.stride >= packed && source.byteOffset <= bytes.size() &&
                      packed <= bytes.size() - source.byteOffset &&
                      rows.count - 1 <= (bytes.size() - source.byteOffset - packed) / rows.stride;
    expect(fits, fmt::format("{} rows of {} bytes at byte {} do not fit into the bufferView of {} bytes", rows.count, packed,
                             source.byteOffset, bytes.size()));
    rows.first = bytes.data() + source.byteOffset;
    return rows;
}

std::vector<std::uint32_t> triangle_indices(const tinygltf::Model& model, int indices, int mode, std::size_t vertex_count)
{
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP && mode != TINYGLTF_MODE_TRIANGLE_FAN)
        return {};
    std::vector<std::uint32_t> corners;
    if (indices < 0)
    {
        corners.resize(vertex_count);
        std::iota(corners.begin(), corners.end(), 0U);
    }
    else
    {
        const AccessorRows rows = accessor_rows(model, indices, 1, 1);
        const std::string place = entry("accessors", static_cast<std::size_t>(indices));
        if (rows.normalized || (rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
                                rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
                                rows.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
            throw Error(place + "expected unsigned integers as indices");
        corners.reserve(rows.count);
        for (std::size_t i = 0; i < rows.count; ++i)
        {
            corners.push_back(rows.integer_at(i));
            if (corners.back() >= vertex_count)
                throw Error(fmt::format("{}index {} names vertex {} of {}", place, i, corners.back(), vertex_count));
        }
    }
    if (mode == TINYGLTF_MODE_TRIANGLES)
    {
        if (corners.size() % 3 != 0)
            throw Error(fmt::format("a primitive of triangles has {} corners; expected a multiple of 3", corners.size()));
        return corners;
    }
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 2; i < corners.size(); ++i)
    {
        const bool is_fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
        const bool is_turned = !is_fan && i % 2 == 1;
        const std::uint32_t first = is_fan ? corners[0] : corners[i - 2];
        triangles.insert(triangles.end(), {first, corners[is_turned ? i : i - 1], corners[is_turned ? i - 1 : i]});
    }
    return triangles;
}

}  // namespace fresco::gltf
