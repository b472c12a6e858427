#include <fresco/gltf/compression.h>
#include <fresco/gltf/gltf_file.h>

#include <fresco/error.h>
#include <fresco/mesh.h>

#include <draco/compression/decode.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <utility>

namespace fresco::gltf
{
namespace
{

/// Triangles or vertices per byte of the stream: of flat grids, the smallest, some hundreds.
constexpr std::size_t most_per_byte = 4096;

struct Claim
{
    std::size_t vertices = 0;
    std::size_t faces = 0;
};

[[noreturn]] void fail(std::size_t at, const std::string& what)
{
    throw Error(fmt::format("KHR_draco_mesh_compression: byte {} of the stream: {}", at, what));
}

/// A stream claims to hold so much. Draco takes memory for it before it looks at what follows.
Claim claim_of(std::span<const std::byte> stream)
{
    constexpr std::size_t header_bytes = 11;
    constexpr unsigned metadata = 0x80;
    const auto byte = [&](std::size_t at)
    {
        if (at >= stream.size())
            fail(stream.size(), "it ends: the file is truncated");
        return std::to_integer<unsigned>(stream[at]);
    };
    if (stream.size() < header_bytes || std::memcmp(stream.data(), "DRACO", 5) != 0)
        fail(0, "expected DRACO: the file is damaged");
    if (byte(5) != 2 || byte(6) != 2)
        fail(5, fmt::format("Draco {}.{}; glTF has 2.2: export the model again", byte(5), byte(6)));
    if (byte(7) != 1 || byte(8) > 1)
        fail(7, "expected a mesh of triangles");
    if ((byte(10) & metadata) != 0)
        fail(9, "it has metadata, which is not supported: export the model again");
    std::size_t at = header_bytes;
    const auto number = [&]
    {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 35; shift += 7)
        {
            const unsigned part = byte(at++);
            value |= std::uint64_t{part & 0x7FU} << shift;
            if (part < 0x80)
                return static_cast<std::size_t>(value);
        }
        fail(at, "a number of more than 32 bits: the file is damaged");
    };
    Claim claim;
    const bool is_edgebreaker = byte(8) == 1;
    at += is_edgebreaker ? 1 : 0;  // The kind of traversal.
    for (std::size_t* const each :
         is_edgebreaker ? std::array{&claim.vertices, &claim.faces} : std::array{&claim.faces, &claim.vertices})
        *each = number();
    return claim;
}

std::unique_ptr<draco::Mesh> unpacked(std::span<const std::byte> stream)
{
    try
    {
        draco::DecoderBuffer buffer;
        buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
        draco::Decoder decoder;
        auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
        if (!mesh.ok())
            fail(stream.size() - static_cast<std::size_t>(buffer.remaining_size()),
                 fmt::format("Draco cannot unpack it ({}): the file is damaged", mesh.status().error_msg_string()));
        return std::move(mesh).value();
    }
    catch (const Error&)
    {
        throw;
    }
    catch (const std::exception& error)
    {
        fail(0, fmt::format("Draco cannot unpack it ({}): the file is damaged", error.what()));
    }
}

template <class T>
std::vector<unsigned char> rows_of(const draco::PointAttribute& attribute, std::size_t count)
{
    const auto components = static_cast<std::size_t>(attribute.num_components());
    std::vector<T> row(components);
    std::vector<unsigned char> bytes(count * components * sizeof(T));
    for (std::size_t i = 0; i < count; ++i)
    {
        const auto value = attribute.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
        if (!attribute.ConvertValue<T>(value, static_cast<std::int8_t>(components), row.data()))
            throw Error(fmt::format("KHR_draco_mesh_compression: the value of vertex {} does not fit its accessor", i));
        std::memcpy(bytes.data() + i * components * sizeof(T), row.data(), components * sizeof(T));
    }
    return bytes;
}

tinygltf::Accessor& accessor_at(tinygltf::Model& model, int number)
{
    if (number < 0 || static_cast<std::size_t>(number) >= model.accessors.size())
        throw Error(fmt::format("accessor {} of {}", number, model.accessors.size()));
    return model.accessors[static_cast<std::size_t>(number)];
}

void expect_count(int accessor, std::size_t says, std::size_t holds)
{
    if (says != holds)
        throw Error(fmt::format("{}it says {} rows, its Draco stream holds {}: the file is damaged",
                                entry("accessors", static_cast<std::size_t>(accessor)), says, holds));
}

void place(tinygltf::Model& model, tinygltf::Accessor& accessor, std::vector<unsigned char> bytes)
{
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(model.buffers.size());
    view.byteLength = bytes.size();
    model.buffers.emplace_back().data = std::move(bytes);
    accessor.bufferView = static_cast<int>(model.bufferViews.size());
    accessor.byteOffset = 0;
    accessor.sparse.isSparse = false;
    model.bufferViews.push_back(std::move(view));
}

}  // namespace

void unpack_draco(tinygltf::Model& model, tinygltf::Primitive& primitive, std::span<const std::byte> stream, const Value& form)
{
    const auto [vertices, faces] = claim_of(stream);
    tinygltf::Accessor& indices = accessor_at(model, primitive.indices);
    expect_count(primitive.indices, indices.count, 3 * faces);
    if (std::max(vertices, faces) > MeshLimits{}.max_faces || std::max(vertices, faces) / most_per_byte > stream.size())
        fail(0, fmt::format("{} bytes that claim {} vertices and {} triangles: the file is damaged", stream.size(), vertices,
                            faces));
    const std::unique_ptr<draco::Mesh> mesh = unpacked(stream);
    std::vector<unsigned char> corners(12 * std::size_t{mesh->num_faces()});
    for (std::uint32_t f = 0; f < mesh->num_faces(); ++f)
    {
        const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(f));
        const std::array<std::uint32_t, 3> numbers{face[0].value(), face[1].value(), face[2].value()};
        std::memcpy(corners.data() + 12 * std::size_t{f}, numbers.data(), sizeof numbers);
    }
    expect_count(primitive.indices, indices.count, corners.size() / 4);
    indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    indices.normalized = false;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    place(model, indices, std::move(corners));
    for (const auto& [name, id] : form.at("attributes").as_map())
    {
        const auto used = primitive.attributes.find(name);
        if (used == primitive.attributes.end())
            continue;
        tinygltf::Accessor& accessor = accessor_at(model, used->second);
        expect_count(used->second, accessor.count, mesh->num_points());
        const draco::PointAttribute* const attribute = mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(id.as_int()));
        if (attribute == nullptr ||
            attribute->num_components() != tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)))
            throw Error(fmt::format("KHR_draco_mesh_compression: the stream has no attribute {} of the components of {}{}",
                                    id.as_int(), entry("accessors", static_cast<std::size_t>(used->second)), name));
        place(model, accessor,
              with_component(accessor.componentType, [&]<class T>(T) { return rows_of<T>(*attribute, accessor.count); }));
    }
}

}  // namespace fresco::gltf
