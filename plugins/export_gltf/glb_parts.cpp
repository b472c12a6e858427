#include "glb_parts.h"

#include <fresco/gltf/gltf_file.h>

#include <array>
#include <cstdint>

using namespace fresco;

GlbParts parts_of(std::string_view glb)
{
    const auto chunks = gltf::chunks_of(std::as_bytes(std::span(glb)));
    return {parse_json(chunks.json, "JSON"), {reinterpret_cast<const char*>(chunks.binary.data()), chunks.binary.size()}};
}

std::string assembled(const Value& document, std::string_view binary)
{
    std::string json = to_json(document);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const auto words = [](auto... numbers)
    {
        const std::array<std::uint32_t, sizeof...(numbers)> row{static_cast<std::uint32_t>(numbers)...};
        return std::string(reinterpret_cast<const char*>(row.data()), sizeof row);
    };
    std::string glb = "glTF" + words(2, 28 + json.size() + binary.size(), json.size()) + "JSON" + json + words(binary.size()) +
                      std::string("BIN\0", 4);
    glb += binary;
    return glb;
}
