#include "glb.h"

#include <fresco/error.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/numerics/numerics.h>
#include <fresco/texturing/texture_pictures.h>

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <span>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{

/// The two chunks of a GLB.
struct GlbParts
{
    Value document;
    std::string_view binary;  ///< Part of the parsed text; borrowed.
};

/// The chunks of a GLB. Throws Error naming the offset.
GlbParts parts_of(std::string_view glb)
{
    const auto chunks = gltf::chunks_of(std::as_bytes(std::span(glb)));
    return {parse_json(chunks.json, "JSON"), {reinterpret_cast<const char*>(chunks.binary.data()), chunks.binary.size()}};
}

/// A GLB of these chunks; `binary` has a multiple of four bytes.
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

constexpr double last_step = 65535;
constexpr double texcoord_rounding = 1e-5;

/// The least float that reaches the box's far side in 65535 steps; 1 for a box without extent.
float step_for(const numerics::Bounds<float>& box)
{
    const Vec3d extent = vec_cast<double>(box.high) - vec_cast<double>(box.low);
    const double longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0))
        return 1;
    auto step = static_cast<float>(longest / last_step);
    if (double{step} * last_step < longest)
        step = std::nextafter(step, std::numeric_limits<float>::infinity());
    return step;
}

std::uint16_t nearest_step(double steps)
{
    return static_cast<std::uint16_t>(std::lround(std::clamp(steps, 0.0, last_step)));
}

std::uint16_t texcoord_step(double at)
{
    if (!(at >= -texcoord_rounding && at <= 1 + texcoord_rounding))
        throw Error(
            fmt::format("option \"quantize\": a texcoord is {:.6g}; expected 0 to 1: set quantize: false for this mesh", at));
    return nearest_step(at * last_step);
}

std::int8_t normal_step(float component)
{
    return static_cast<std::int8_t>(std::lround(double{component} * 127));
}

}  // namespace

QuantizedMesh quantized(const WeldedMesh& mesh)
{
    numerics::Bounds<float> box;
    for (const Vec3f p : mesh.positions)
        box.add(p);
    QuantizedMesh result;
    result.origin = box.low;
    result.step_m = step_for(box);
    const auto along = [&](float p, float low) { return nearest_step((double{p} - double{low}) / double{result.step_m}); };
    for (const Vec3f p : mesh.positions)
        result.positions.push_back({along(p.x, box.low.x), along(p.y, box.low.y), along(p.z, box.low.z), 0});
    for (const Vec3f n : mesh.normals)
        result.normals.push_back({normal_step(n.x), normal_step(n.y), normal_step(n.z), 0});
    for (const auto& [x, y, z, w] : mesh.tangents)
        result.tangents.push_back({normal_step(x), normal_step(y), normal_step(z), normal_step(w)});
    for (const Vec2f uv : mesh.texcoords)
        result.texcoords.push_back({texcoord_step(double{uv.x}), texcoord_step(1 - double{uv.y})});
    return result;
}

namespace
{

constexpr const char* extension = "EXT_meshopt_compression";

template <class T>
void reorder(std::vector<T>& values, const std::vector<unsigned>& remap)
{
    if (values.empty())
        return;
    std::vector<T> result(values.size());
    meshopt_remapVertexBuffer(result.data(), values.data(), values.size(), sizeof(T), remap.data());
    values = std::move(result);
}

std::string first_bytes(std::string stream, std::size_t count)
{
    if (count == 0 || count > stream.size())
        throw Error("meshoptimizer could not compress the mesh");
    stream.resize(count);
    return stream;
}

unsigned char* raw(std::string& bytes)
{
    return reinterpret_cast<unsigned char*>(bytes.data());
}

std::string encoded_rows(std::string_view rows, std::size_t stride)
{
    // The versions that EXT_meshopt_compression names, here and below.
    meshopt_encodeVertexVersion(0);
    std::string stream(meshopt_encodeVertexBufferBound(rows.size() / stride, stride), '\0');
    return first_bytes(stream, meshopt_encodeVertexBuffer(raw(stream), stream.size(), rows.data(), rows.size() / stride, stride));
}

std::string encoded_triangles(std::string_view bytes, std::size_t stride)
{
    std::vector<unsigned> indices(bytes.size() / stride);
    for (std::size_t i = 0; i < indices.size(); ++i)
        std::memcpy(&indices[i], bytes.data() + i * stride, stride);
    meshopt_encodeIndexVersion(1);
    std::string stream(meshopt_encodeIndexBufferBound(indices.size(), *std::ranges::max_element(indices) + std::size_t{1}), '\0');
    return first_bytes(stream, meshopt_encodeIndexBuffer(raw(stream), stream.size(), indices.data(), indices.size()));
}

std::size_t size_at(const Value& map, std::string_view key)
{
    const Value* const found = map.find(key);
    return found == nullptr ? 0 : static_cast<std::size_t>(found->as_int());
}

/// Compresses the vertices and indices of a GLB of make_glb by EXT_meshopt_compression: a pass over the finished GLB, because
/// tinygltf supports no extensions of views. Corners of a triangle may rotate: (a, b, c) to (b, c, a).
std::string compressed_glb(std::string_view glb)
{
    auto [document, plain] = parts_of(glb);
    // Views of accessors come first, in the accessors' order; then the picture's, which stays as it is. Views of compressed data
    // lie in buffer 1, which no file holds.
    const Value::List& accessors = document.at("accessors").as_list();
    Value::List& views = document.find("bufferViews")->as_list();
    std::string binary;
    std::size_t restored_bytes = 0;
    for (std::size_t i = 0; i < views.size(); ++i)
    {
        Value& view = views[i];
        const std::string_view bytes = plain.substr(size_at(view, "byteOffset"), size_at(view, "byteLength"));
        const std::size_t offset = binary.size();
        if (i < accessors.size())
        {
            const std::size_t count = size_at(accessors[i], "count");
            const std::size_t stride = bytes.size() / std::max(count, std::size_t{1});
            const bool is_rows = size_at(view, "target") == TINYGLTF_TARGET_ARRAY_BUFFER;
            binary += is_rows ? encoded_rows(bytes, stride) : encoded_triangles(bytes, stride);
            view.set("extensions", Value::Map{{extension, Value::Map{{"buffer", 0},
                                                                     {"byteOffset", offset},
                                                                     {"byteLength", binary.size() - offset},
                                                                     {"byteStride", stride},
                                                                     {"count", count},
                                                                     {"mode", is_rows ? "ATTRIBUTES" : "TRIANGLES"}}}});
            view.set("buffer", 1);
            view.set("byteOffset", restored_bytes);
            if (is_rows)
                view.set("byteStride", stride);
            restored_bytes = (restored_bytes + bytes.size() + 3) / 4 * 4;
        }
        else
        {
            binary += bytes;
            view.set("byteOffset", offset);
        }
        binary.resize((binary.size() + 3) / 4 * 4);
    }
    document.set("buffers", Value::List{Value::Map{{"byteLength", binary.size()}},
                                        Value::Map{{"byteLength", restored_bytes},
                                                   {"extensions", Value::Map{{extension, Value::Map{{"fallback", true}}}}}}});
    for (const char* const key : {"extensionsUsed", "extensionsRequired"})
    {
        const Value* const others = document.find(key);
        Value::List names = others == nullptr ? Value::List{} : others->as_list();
        names.emplace_back(extension);
        document.set(key, std::move(names));
    }
    return assembled(document, binary);
}

constexpr std::size_t largest_file = std::numeric_limits<std::uint32_t>::max() - (1U << 20U);  // leaves room for the JSON part

/// Restarts strips in graphics hardware: no vertex has this number.
constexpr std::size_t restart_index = 65535;

/// How the rows of an accessor are stored.
struct Layout
{
    int component_type;
    int type;
    bool normalized = false;
};

/// Appends bytes to the file's buffer, at a multiple of four, and a view of them.
int add_view(tinygltf::Model& model, std::span<const std::byte> bytes, int target = 0, std::size_t stride = 0)
{
    auto& data = model.buffers[0].data;
    tinygltf::BufferView& view = model.bufferViews.emplace_back();
    view.buffer = 0;
    view.byteOffset = data.size();
    view.byteLength = bytes.size();
    view.byteStride = stride;
    view.target = target;
    const auto* const begin = reinterpret_cast<const unsigned char*>(bytes.data());
    data.insert(data.end(), begin, begin + bytes.size());
    data.resize((data.size() + 3) / 4 * 4);
    return static_cast<int>(model.bufferViews.size() - 1);
}

int add_accessor(tinygltf::Model& model, int view, std::size_t count, const Layout& layout)
{
    tinygltf::Accessor& accessor = model.accessors.emplace_back();
    accessor.bufferView = view;
    accessor.componentType = layout.component_type;
    accessor.count = count;
    accessor.type = layout.type;
    accessor.normalized = layout.normalized;
    return static_cast<int>(model.accessors.size() - 1);
}

template <class Row>
int add_rows(tinygltf::Model& model, const std::vector<Row>& rows, const Layout& layout)
{
    const bool is_packed = layout.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    const int view = add_view(model, std::as_bytes(std::span(rows)), TINYGLTF_TARGET_ARRAY_BUFFER, is_packed ? 0 : sizeof(Row));
    return add_accessor(model, view, rows.size(), layout);
}

int add_indices(tinygltf::Model& model, const std::vector<std::uint32_t>& indices, std::size_t vertices)
{
    const auto add = [&](const auto& narrow, int component_type)
    {
        const int view = add_view(model, std::as_bytes(std::span(narrow)), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
        return add_accessor(model, view, indices.size(), {component_type, TINYGLTF_TYPE_SCALAR});
    };
    if (vertices > restart_index)
        return add(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
    return add(std::vector<std::uint16_t>(indices.begin(), indices.end()), TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
}

/// "min" and "max" of the first three numbers of each row.
template <class Row>
void set_bounds(tinygltf::Accessor& accessor, const std::vector<Row>& rows, const auto& component)
{
    for (std::size_t i = 0; i < 3; ++i)
    {
        const auto along = [&](const Row& row) { return static_cast<double>(component(row, i)); };
        const auto [low, high] = std::ranges::minmax(rows, {}, along);
        accessor.minValues.push_back(along(low));
        accessor.maxValues.push_back(along(high));
    }
}

/// Linear light in 16 bits, from which every step of sRGB comes back.
int add_colors(tinygltf::Model& model, const WeldedMesh& mesh)
{
    std::vector<std::array<std::uint16_t, 4>> rows;
    for (const Rgb8& color : mesh.colors)
    {
        const auto light = [](std::uint8_t step)
        { return static_cast<std::uint16_t>(std::lround(texturing::to_linear(step) * 65535)); };
        rows.push_back({light(color[0]), light(color[1]), light(color[2]), 65535});
    }
    return add_rows(model, rows, {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, true});
}

void add_plain(tinygltf::Model& model, const WeldedMesh& mesh, bool has_normals, std::map<std::string, int>& attributes)
{
    const Layout vec3{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3};
    attributes["POSITION"] = add_rows(model, mesh.positions, vec3);
    set_bounds(model.accessors.back(), mesh.positions, [](Vec3f p, std::size_t i) { return i == 0 ? p.x : i == 1 ? p.y : p.z; });
    if (has_normals)
        attributes["NORMAL"] = add_rows(model, mesh.normals, vec3);
    if (has_normals && !mesh.tangents.empty())
        attributes["TANGENT"] = add_rows(model, mesh.tangents, {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC4});
    std::vector<Vec2f> flipped = mesh.texcoords;
    for (Vec2f& uv : flipped)
        uv.y = 1 - uv.y;
    if (!flipped.empty())
        attributes["TEXCOORD_0"] = add_rows(model, flipped, {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2});
}

void add_quantized(tinygltf::Model& model, const QuantizedMesh& mesh, bool has_normals, std::map<std::string, int>& attributes)
{
    attributes["POSITION"] = add_rows(model, mesh.positions, {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC3});
    set_bounds(model.accessors.back(), mesh.positions, [](const auto& row, std::size_t i) { return row[i]; });
    if (has_normals)
        attributes["NORMAL"] = add_rows(model, mesh.normals, {TINYGLTF_COMPONENT_TYPE_BYTE, TINYGLTF_TYPE_VEC3, true});
    if (has_normals && !mesh.tangents.empty())
        attributes["TANGENT"] = add_rows(model, mesh.tangents, {TINYGLTF_COMPONENT_TYPE_BYTE, TINYGLTF_TYPE_VEC4, true});
    if (!mesh.texcoords.empty())
        attributes["TEXCOORD_0"] =
            add_rows(model, mesh.texcoords, {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC2, true});
}

/// The parent turns the world upright, the child takes whole steps to meters.
void add_nodes(tinygltf::Model& model, const std::array<double, 4>& turn, const QuantizedMesh* quantized)
{
    tinygltf::Node shown;
    shown.name = "room";
    shown.mesh = 0;
    std::vector<double> rotation;
    if (turn != std::array<double, 4>{0, 0, 0, 1})
        rotation.assign(turn.begin(), turn.end());
    if (quantized != nullptr)
    {
        const Vec3d origin = vec_cast<double>(quantized->origin);
        shown.translation = {origin.x, origin.y, origin.z};
        shown.scale.assign(3, double{quantized->step_m});
        if (!rotation.empty())
        {
            tinygltf::Node& parent = model.nodes.emplace_back();
            parent.name = "upright";
            parent.rotation = rotation;
            parent.children = {1};
        }
    }
    else
        shown.rotation = rotation;
    model.nodes.push_back(shown);
    model.defaultScene = 0;
    model.scenes.emplace_back().nodes = {0};
}

void add_material(tinygltf::Model& model, const std::vector<std::byte>& image, const GlbOptions& options)
{
    tinygltf::Material& material = model.materials.emplace_back();
    material.name = "texture";
    material.pbrMetallicRoughness.metallicFactor = 0;
    if (options.material == GltfMaterial::unlit)
    {
        material.extensions[unlit_extension] = tinygltf::Value(tinygltf::Value::Object{});
        model.extensionsUsed.emplace_back(unlit_extension);
    }
    if (image.empty())
        return;
    const auto add_texture = [&](const std::vector<std::byte>& bytes)
    {
        tinygltf::Image& picture = model.images.emplace_back();
        picture.bufferView = add_view(model, bytes);
        picture.mimeType = options.image_type;
        tinygltf::Texture& texture = model.textures.emplace_back();
        texture.sampler = 0;
        return texture.source = static_cast<int>(model.images.size() - 1);
    };
    material.pbrMetallicRoughness.baseColorTexture.index = add_texture(image);
    if (!options.relief.normals.empty())
    {
        material.normalTexture.index = add_texture(options.relief.normals);
        material.pbrMetallicRoughness.metallicRoughnessTexture.index = add_texture(options.relief.roughness);
    }
    tinygltf::Sampler& sampler = model.samplers.emplace_back();
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
}

/// tinygltf's extras have neither whole numbers of 64 bits nor empty lists and maps.
std::string with_origin(std::string_view glb, const Value& origin)
{
    GlbParts parts = parts_of(glb);
    parts.document.find("asset")->set("extras", origin);
    return assembled(parts.document, parts.binary);
}

}  // namespace

void order_for_compression(WeldedMesh& mesh)
{
    const std::size_t vertices = mesh.positions.size();
    std::vector<unsigned> indices(mesh.indices.size());
    meshopt_optimizeVertexCacheStrip(indices.data(), mesh.indices.data(), mesh.indices.size(), vertices);
    std::vector<unsigned> remap(vertices);
    meshopt_optimizeVertexFetchRemap(remap.data(), indices.data(), indices.size(), vertices);
    meshopt_remapIndexBuffer(mesh.indices.data(), indices.data(), indices.size(), remap.data());
    reorder(mesh.positions, remap);
    reorder(mesh.normals, remap);
    reorder(mesh.tangents, remap);
    reorder(mesh.texcoords, remap);
    reorder(mesh.colors, remap);
}

std::string make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    const std::size_t bytes = mesh.indices.size() * 4 + mesh.positions.size() * 56 + image.size() +
                              options.relief.normals.size() + options.relief.roughness.size();
    if (bytes > largest_file)
        throw Error(fmt::format(
            "the mesh and its picture take {} MiB; a GLB file holds at most 4096: decimate the mesh or set max_texture_px",
            bytes >> 20U));
    const bool has_normals = options.material == GltfMaterial::pbr;
    const QuantizedMesh steps = options.quantize ? quantized(mesh) : QuantizedMesh{};
    tinygltf::Model model;
    model.asset.version = "2.0";
    model.asset.generator = "fresco";
    model.buffers.emplace_back();
    if (options.quantize)
        model.extensionsUsed = model.extensionsRequired = {quantization_extension};
    tinygltf::Mesh& room = model.meshes.emplace_back();
    room.name = "room";
    tinygltf::Primitive& primitive = room.primitives.emplace_back();
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    primitive.indices = add_indices(model, mesh.indices, mesh.positions.size());
    if (options.quantize)
        add_quantized(model, steps, has_normals, primitive.attributes);
    else
        add_plain(model, mesh, has_normals, primitive.attributes);
    if (!mesh.colors.empty())
        primitive.attributes["COLOR_0"] = add_colors(model, mesh);
    add_nodes(model, options.turn, options.quantize ? &steps : nullptr);
    add_material(model, image, options);
    std::string glb = gltf::written_glb(model);
    if (options.compress)
        glb = compressed_glb(glb);
    return options.origin.as_map().empty() ? glb : with_origin(glb, options.origin);
}
