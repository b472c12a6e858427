#include "glb.h"

#include "glb_parts.h"
#include "meshopt_compression.h"
#include "quantized_mesh.h"

#include <fresco/error.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/texturing/linear_light.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <span>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
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
    material.pbrMetallicRoughness.baseColorTexture.index = 0;
    tinygltf::Texture& texture = model.textures.emplace_back();
    texture.sampler = 0;
    texture.source = 0;
    tinygltf::Image& picture = model.images.emplace_back();
    picture.bufferView = add_view(model, image);
    picture.mimeType = options.image_type;
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

std::string make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    const std::size_t bytes = mesh.indices.size() * 4 + mesh.positions.size() * 40 + image.size();
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
