#include "plain_glb.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace plain
{

namespace
{
using nlohmann::json;

void expect(bool condition, const char* what)
{
    if (!condition)
        throw std::runtime_error(std::string("not the GLB that was expected: ") + what);
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at)
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes.at(at + i))) << (8 * i);
    return value;
}

double as_float(const std::string& bytes, std::size_t at)
{
    const std::uint32_t bits = little_endian(bytes, at);
    float value = 0;
    std::memcpy(&value, &bits, 4);
    return double{value};
}

/// Where an accessor's elements begin in the binary chunk.
std::size_t begin_of(const json& root, const json& accessor)
{
    const json& view = root.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    expect(!view.contains("byteStride"), "interleaved data");
    return view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
}
}  // namespace

Model read_glb(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    expect(bytes.size() > 28 && bytes.substr(0, 4) == "glTF" && little_endian(bytes, 4) == 2, "header");
    const std::size_t json_size = little_endian(bytes, 12);
    const json root = json::parse(bytes.substr(20, json_size));
    const std::string binary = bytes.substr(28 + json_size);

    const json& primitive = root.at("meshes").at(0).at("primitives").at(0);
    expect(primitive.value("mode", 4) == 4, "triangles");
    const auto accessor = [&](const json& index) -> const json& { return root.at("accessors").at(index.get<std::size_t>()); };
    const json& indices = accessor(primitive.at("indices"));
    const json& positions = accessor(primitive.at("attributes").at("POSITION"));
    const json& texcoords = accessor(primitive.at("attributes").at("TEXCOORD_0"));
    const bool is_short = indices.at("componentType") == 5123;
    expect((is_short || indices.at("componentType") == 5125) && indices.at("type") == "SCALAR", "16-bit or 32-bit indices");
    expect(positions.at("componentType") == 5126 && positions.at("type") == "VEC3", "float positions");
    expect(texcoords.at("componentType") == 5126 && texcoords.at("type") == "VEC2", "float texcoords");

    Model model;
    const std::size_t index_begin = begin_of(root, indices);
    const std::size_t position_begin = begin_of(root, positions);
    const std::size_t texcoord_begin = begin_of(root, texcoords);
    for (std::size_t i = 0; i < indices.at("count").get<std::size_t>(); ++i)
    {
        const std::size_t vertex =
            is_short ? little_endian(binary, index_begin + 2 * i) & 0xFFFFU : little_endian(binary, index_begin + 4 * i);
        if (i % 3 == 0)
            model.triangles.emplace_back();
        Corner& corner = model.triangles.back()[i % 3];
        for (std::size_t axis = 0; axis < 3; ++axis)
            corner.position[axis] = as_float(binary, position_begin + 12 * vertex + 4 * axis);
        corner.u = as_float(binary, texcoord_begin + 8 * vertex);
        corner.v = as_float(binary, texcoord_begin + 8 * vertex + 4);
    }

    const json& view = root.at("bufferViews").at(root.at("images").at(0).at("bufferView").get<std::size_t>());
    const std::string picture = binary.substr(view.value("byteOffset", std::size_t{0}), view.at("byteLength").get<std::size_t>());
    model.picture.assign(picture.begin(), picture.end());
    return model;
}

}  // namespace plain
