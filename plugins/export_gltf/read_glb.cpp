#include "read_glb.h"

#include "compression.h"
#include "gltf_names.h"

#include <fresco/error.h>
#include <fresco/texturing/linear_light.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>
#include <utility>

using namespace fresco;

namespace
{
constexpr double unit_tolerance = 0.02;  // of normals in 8 bits

void expect(bool good, const std::string& what)
{
    if (!good)
        throw Error(what);
}

std::size_t word_at(std::span<const std::byte> bytes, std::size_t at)
{
    expect(at + 4 <= bytes.size(), "ends at byte " + std::to_string(bytes.size()) + " inside of a header");
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, 4);
    return word;
}

std::size_t index_of(const Value& value)
{
    const std::int64_t number = value.as_int();
    expect(number >= 0, "a number that is not negative was expected, not " + std::to_string(number));
    return static_cast<std::size_t>(number);
}

std::size_t index_or(const Value& map, std::string_view key, std::size_t otherwise)
{
    const Value* const found = map.find(key);
    return found == nullptr ? otherwise : index_of(*found);
}

const Value& element(const Value& list, std::size_t at, const char* name)
{
    expect(at < list.as_list().size(), std::string(name) + "[" + std::to_string(at) + "]: there is none");
    return list.as_list()[at];
}

/// The JSON and the binary part.
struct Chunks
{
    Value document;
    std::span<const std::byte> binary;
};

Chunks chunks_of(std::span<const std::byte> file, std::string_view source)
{
    expect(word_at(file, 0) == gltf::magic && word_at(file, 4) == 2,
           "byte 0: the header of a GLB file of version 2 was expected");
    expect(word_at(file, 8) == file.size(),
           "byte 8: tells a length of " + std::to_string(word_at(file, 8)) + ", the file has " + std::to_string(file.size()));
    const std::size_t json_bytes = word_at(file, 12);
    expect(word_at(file, 16) == gltf::json_chunk && json_bytes % 4 == 0 && json_bytes <= file.size() - 20,
           "byte 12: a chunk of JSON inside of the file was expected");
    const std::size_t binary_at = 20 + json_bytes;
    const std::size_t binary_bytes = word_at(file, binary_at);
    expect(word_at(file, binary_at + 4) == gltf::binary_chunk && binary_bytes % 4 == 0 &&
               binary_bytes == file.size() - binary_at - 8,
           "byte " + std::to_string(binary_at) + ": a binary chunk to the end of the file was expected");
    const auto* const text = reinterpret_cast<const char*>(file.data() + 20);
    return {parse_json({text, json_bytes}, source), file.subspan(binary_at + 8)};
}

/// The rows of one accessor.
struct Rows
{
    std::vector<std::byte> bytes;
    std::size_t count = 0;
    std::size_t stride = 0;
    std::size_t components = 0;
    int component_type = 0;
    bool normalized = false;

    double at(std::size_t row, std::size_t component) const
    {
        const std::byte* const from = bytes.data() + row * stride;
        switch (component_type)
        {
        case gltf::int8:
            return scaled<std::int8_t>(from, component, 127);
        case gltf::uint16:
            return scaled<std::uint16_t>(from, component, 65535);
        case gltf::uint32:
            return scaled<std::uint32_t>(from, component, 1);
        default:
            return scaled<float>(from, component, 1);
        }
    }

  private:
    template <class T>
    double scaled(const std::byte* row, std::size_t component, double greatest) const
    {
        T value{};
        std::memcpy(&value, row + component * sizeof(T), sizeof(T));
        return normalized ? std::max(static_cast<double>(value) / greatest, -1.0) : static_cast<double>(value);
    }
};

std::size_t bytes_of(int component_type)
{
    switch (component_type)
    {
    case gltf::int8:
        return 1;
    case gltf::uint16:
        return 2;
    case gltf::uint32:
    case gltf::float32:
        return 4;
    default:
        throw Error("componentType: " + std::to_string(component_type) + " is none that export.gltf writes");
    }
}

class Document
{
  public:
    explicit Document(const Chunks& chunks) : root_(chunks.document), binary_(chunks.binary)
    {
        check_buffers();
        check_extensions();
    }

    const Value& primitive() const
    {
        const Value& mesh = element(root_.at("meshes"), 0, "meshes");
        const Value& result = element(mesh.at("primitives"), 0, "primitives");
        expect(index_of(result.at("mode")) == gltf::triangles, "primitives[0]: mode: triangles (4) were expected");
        return result;
    }

    Rows rows(std::size_t accessor_index, std::size_t components) const
    {
        const Value& accessor = element(root_.at("accessors"), accessor_index, "accessors");
        const std::string place = "accessors[" + std::to_string(accessor_index) + "]: ";
        const std::map<std::string, std::size_t> types{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
        const auto type = types.find(accessor.at("type").as_string());
        expect(type != types.end() && type->second == components, place + "type: another number of components was expected");
        Rows result;
        result.components = components;
        result.component_type = static_cast<int>(accessor.at("componentType").as_int());
        result.count = index_of(accessor.at("count"));
        if (const Value* const normalized = accessor.find("normalized"))
            result.normalized = normalized->as_bool();
        const std::size_t packed = components * bytes_of(result.component_type);
        const std::size_t view_index = index_of(accessor.at("bufferView"));
        const Value& view = element(root_.at("bufferViews"), view_index, "bufferViews");
        result.stride = index_or(view, "byteStride", packed);
        expect(result.stride >= packed && (result.stride == packed || result.stride % 4 == 0),
               place + "rows of " + std::to_string(packed) + " bytes cannot lie " + std::to_string(result.stride) + " apart");
        result.bytes = bytes_of_view(view, view_index);
        expect(result.count > 0 && result.bytes.size() / result.stride >= result.count,
               place + std::to_string(result.count) + " rows do not fit into their view of " +
                   std::to_string(result.bytes.size()) + " bytes");
        check_bounds(accessor, result, place);
        return result;
    }

    /// Image 0: its type and its bytes; nothing where there is none.
    std::pair<std::string, std::vector<std::byte>> picture() const
    {
        check_material();
        if (root_.find("images") == nullptr)
            return {};
        const Value& image = element(root_.at("images"), 0, "images");
        const std::size_t view = index_of(image.at("bufferView"));
        auto bytes = bytes_of_view(element(root_.at("bufferViews"), view, "bufferViews"), view);
        const std::string type = image.at("mimeType").as_string();
        const std::string signature = type == "image/png" ? "\x89PNG\r\n\x1a\n" : "\xFF\xD8\xFF";
        expect(type == "image/png" || type == "image/jpeg", "images[0]: mimeType: image/png or image/jpeg was expected");
        expect(bytes.size() > signature.size() && std::memcmp(bytes.data(), signature.data(), signature.size()) == 0,
               "images[0]: the bytes do not begin as " + type);
        return {type, std::move(bytes)};
    }

    /// The node that shows the mesh.
    const Value& mesh_node() const
    {
        const Value& scene = element(root_.at("scenes"), index_of(root_.at("scene")), "scenes");
        const Value* node = &element(root_.at("nodes"), index_of(element(scene.at("nodes"), 0, "nodes")), "nodes");
        if (node->find("mesh") == nullptr)
            node = &element(root_.at("nodes"), index_of(element(node->at("children"), 0, "children")), "nodes");
        expect(index_of(node->at("mesh")) == 0, "nodes: none shows the mesh");
        return *node;
    }

  private:
    void check_buffers() const
    {
        const std::size_t stored = index_of(element(root_.at("buffers"), 0, "buffers").at("byteLength"));
        expect(stored <= binary_.size() && binary_.size() - stored < 4,
               "buffers[0]: byteLength: " + std::to_string(stored) + ", the binary chunk has " + std::to_string(binary_.size()));
    }

    std::set<std::string> names(std::string_view key) const
    {
        std::set<std::string> result;
        if (const Value* const list = root_.find(key))
            for (const Value& name : list->as_list())
                result.insert(name.as_string());
        return result;
    }

    void check_extensions() const
    {
        const std::set<std::string> known{gltf::unlit, gltf::quantization, gltf::meshopt};
        const auto used = names("extensionsUsed");
        for (const std::string& name : names("extensionsRequired"))
            expect(known.contains(name) && used.contains(name), "extensionsRequired: " + name + " is unknown or not in use");
    }

    void check_material() const
    {
        const Value& material = element(root_.at("materials"), index_of(primitive().at("material")), "materials");
        const Value* const texture = material.at("pbrMetallicRoughness").find("baseColorTexture");
        expect((texture != nullptr) == (root_.find("images") != nullptr), "materials: the picture is not used");
        if (texture != nullptr)
        {
            const Value& found = element(root_.at("textures"), index_of(texture->at("index")), "textures");
            expect(index_of(found.at("source")) == 0, "textures: the picture is not used");
        }
        const Value* const extensions = material.find("extensions");
        const bool is_unlit = extensions != nullptr && extensions->find(gltf::unlit) != nullptr;
        expect(is_unlit == names("extensionsUsed").contains(gltf::unlit), "extensionsUsed: unlit and the material do not agree");
    }

    std::span<const std::byte> stored(const Value& view, const std::string& place) const
    {
        expect(index_of(view.at("buffer")) == 0, place + "buffer: 0 was expected");
        const std::size_t offset = index_or(view, "byteOffset", 0);
        const std::size_t length = index_of(view.at("byteLength"));
        expect(offset % 4 == 0 && offset <= binary_.size() && length <= binary_.size() - offset,
               place + "bytes " + std::to_string(offset) + " to " + std::to_string(offset + length) +
                   " do not lie in the binary chunk, or not at a multiple of 4");
        return binary_.subspan(offset, length);
    }

    std::vector<std::byte> bytes_of_view(const Value& view, std::size_t index) const
    {
        const std::string place = "bufferViews[" + std::to_string(index) + "]: ";
        const Value* const extensions = view.find("extensions");
        if (extensions == nullptr)
        {
            const auto bytes = stored(view, place);
            return {bytes.begin(), bytes.end()};
        }
        expect(names("extensionsRequired").contains(gltf::meshopt), place + "compression is not declared as required");
        const Value& compressed = extensions->at(gltf::meshopt);
        const auto stream = stored(compressed, place);
        const std::size_t count = index_of(compressed.at("count"));
        const std::size_t stride = index_of(compressed.at("byteStride"));
        expect(count <= index_of(view.at("byteLength")) && count * stride == index_of(view.at("byteLength")),
               place + "byteLength: count x byteStride was expected");
        if (compressed.at("mode").as_string() == "ATTRIBUTES")
            return restored_rows(stream, count, stride);
        expect(stride == 2 || stride == 4, place + "byteStride: indices of 2 or 4 bytes were expected");
        const auto indices = restored_triangles(stream, count);
        std::vector<std::byte> bytes(count * stride);
        for (std::size_t i = 0; i < count; ++i)
            std::memcpy(&bytes[i * stride], &indices[i], stride);
        return bytes;
    }

    static void check_bounds(const Value& accessor, const Rows& rows, const std::string& place)
    {
        if (accessor.find("min") == nullptr)
            return;
        for (std::size_t c = 0; c < rows.components; ++c)
        {
            double low = rows.at(0, c);
            double high = low;
            for (std::size_t i = 1; i < rows.count; ++i)
            {
                low = std::min(low, rows.at(i, c));
                high = std::max(high, rows.at(i, c));
            }
            expect(element(accessor.at("min"), c, "min").as_double() == low &&
                       element(accessor.at("max"), c, "max").as_double() == high,
                   place + "min and max are not those of the values");
        }
    }

    const Value& root_;
    std::span<const std::byte> binary_;
};

Vec3d vector_or(const Value& node, std::string_view key, Vec3d otherwise)
{
    const Value* const found = node.find(key);
    if (found == nullptr)
        return otherwise;
    return {element(*found, 0, "node").as_double(), element(*found, 1, "node").as_double(),
            element(*found, 2, "node").as_double()};
}

std::vector<Vec3d> vectors_of(const Rows& rows)
{
    std::vector<Vec3d> result;
    result.reserve(rows.count);
    for (std::size_t i = 0; i < rows.count; ++i)
    {
        const Vec3d v{rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)};
        expect(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z),
               "vertex " + std::to_string(i) + " has a number that is not finite");
        result.push_back(v);
    }
    return result;
}

void read_positions(const Document& document, const Value& attributes, GlbModel& model)
{
    const Rows rows = document.rows(index_of(attributes.at("POSITION")), 3);
    const Vec3d scale = vector_or(document.mesh_node(), "scale", {1, 1, 1});
    const Vec3d origin = vector_or(document.mesh_node(), "translation", {0, 0, 0});
    model.positions = vectors_of(rows);
    for (Vec3d& p : model.positions)
        p = Vec3d{p.x * scale.x, p.y * scale.y, p.z * scale.z} + origin;
}

void read_normals(const Document& document, const Value& attributes, GlbModel& model)
{
    const Value* const accessor = attributes.find("NORMAL");
    if (accessor == nullptr)
        return;
    model.normals = vectors_of(document.rows(index_of(*accessor), 3));
    expect(model.normals.size() == model.positions.size(), "NORMAL: one for each position was expected");
    for (std::size_t i = 0; i < model.normals.size(); ++i)
        expect(std::abs(length(model.normals[i]) - 1) <= unit_tolerance, "NORMAL: " + std::to_string(i) + " has not unit length");
}

void read_colors(const Document& document, const Value& attributes, GlbModel& model)
{
    const Value* const accessor = attributes.find("COLOR_0");
    if (accessor == nullptr)
        return;
    const Rows rows = document.rows(index_of(*accessor), 4);
    expect(rows.count == model.positions.size() && rows.normalized, "COLOR_0: one for each position was expected, normalized");
    for (std::size_t i = 0; i < rows.count; ++i)
        model.colors.push_back({texturing::from_linear(rows.at(i, 0)), texturing::from_linear(rows.at(i, 1)),
                                texturing::from_linear(rows.at(i, 2))});
}

void read_texcoords(const Document& document, const Value& attributes, GlbModel& model)
{
    const Value* const accessor = attributes.find("TEXCOORD_0");
    if (accessor == nullptr)
        return;
    const Rows rows = document.rows(index_of(*accessor), 2);
    expect(rows.count == model.positions.size(), "TEXCOORD_0: one for each position was expected");
    for (std::size_t i = 0; i < rows.count; ++i)
    {
        model.texcoords.push_back({rows.at(i, 0), rows.at(i, 1)});
        expect(std::isfinite(rows.at(i, 0)) && std::isfinite(rows.at(i, 1)),
               "vertex " + std::to_string(i) + " has a texcoord that is not finite");
    }
}

void read_indices(const Document& document, GlbModel& model)
{
    const Rows rows = document.rows(index_of(document.primitive().at("indices")), 1);
    expect(rows.component_type == gltf::uint16 || rows.component_type == gltf::uint32, "indices: whole numbers were expected");
    expect(rows.count % 3 == 0, "indices: three for each triangle were expected");
    for (std::size_t i = 0; i < rows.count; ++i)
    {
        const double vertex = rows.at(i, 0);
        expect(vertex < static_cast<double>(model.positions.size()), "indices: number " + std::to_string(i) + " names vertex " +
                                                                         std::to_string(static_cast<std::uint64_t>(vertex)) +
                                                                         " of " + std::to_string(model.positions.size()));
        model.indices.push_back(static_cast<std::uint32_t>(vertex));
    }
}
}  // namespace

GlbModel read_glb(std::span<const std::byte> file, std::string_view source)
{
    try
    {
        const Chunks chunks = chunks_of(file, source);
        const Document document(chunks);
        const Value& attributes = document.primitive().at("attributes");
        GlbModel model;
        read_positions(document, attributes, model);
        read_normals(document, attributes, model);
        read_texcoords(document, attributes, model);
        read_colors(document, attributes, model);
        read_indices(document, model);
        std::tie(model.image_type, model.image) = document.picture();
        return model;
    }
    catch (const Error& error)
    {
        throw Error(std::string(source) + ": " + error.what());
    }
}
