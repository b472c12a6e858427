#include "check_glb.h"

#include <fresco/error.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/texturing/texture_pictures.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace fresco;
using fresco::gltf::AccessorRows;
using fresco::gltf::entry;
using fresco::gltf::GltfFile;
using fresco::texturing::WeldedMesh;

namespace
{

constexpr double unit_tolerance = 0.02;  // of normals in 8 bits

void expect(bool good, const std::string& what)
{
    if (!good)
        throw Error(what);
}

bool contains(const std::vector<std::string>& names, const std::string& name)
{
    return std::ranges::find(names, name) != names.end();
}

template <class T>
const T& element(const std::vector<T>& list, int at, const char* name)
{
    expect(at >= 0 && static_cast<std::size_t>(at) < list.size(), fmt::format("{}[{}] of {}", name, at, list.size()));
    return list[static_cast<std::size_t>(at)];
}

/// The JSON of the file, whose chunks are as they have to be.
Value checked_json(std::string_view file)
{
    const auto chunks = gltf::chunks_of(std::as_bytes(std::span(file)));
    const std::size_t used = 28 + chunks.json.size() + chunks.binary.size();
    expect(chunks.json.size() % 4 == 0 && chunks.binary.size() % 4 == 0 && used == file.size(),
           "expected a JSON and a BIN chunk, multiples of 4 bytes, to the end of the file");
    const Value document = parse_json(chunks.json, "JSON");
    const auto& buffers = document.at("buffers").as_list();
    expect(!buffers.empty() && buffers[0].at("byteLength").as_int() == static_cast<std::int64_t>(chunks.binary.size()),
           "buffers[0]: byteLength: the BIN chunk has " + std::to_string(chunks.binary.size()));
    return document;
}

/// Of color, normals and roughness; -1: none.
std::array<int, 3> textures_of(const tinygltf::Material& material)
{
    return {material.pbrMetallicRoughness.baseColorTexture.index, material.normalTexture.index,
            material.pbrMetallicRoughness.metallicRoughnessTexture.index};
}

/// The material, its pictures and what is declared belong together.
void check_look(const GltfFile& gltf, const tinygltf::Primitive& primitive)
{
    const auto& model = gltf.model;
    const auto& material = element(model.materials, primitive.material, "materials");
    std::size_t used = 0;
    for (const int texture : textures_of(material))
        if (texture != -1)
            expect(element(model.textures, texture, "textures").source == static_cast<int>(used++),
                   "materials: the picture is unused, or not in the order of color, normals and roughness");
    expect(gltf.images.size() == used, "materials: the picture is unused");
    expect(material.extensions.contains(unlit_extension) == contains(model.extensionsUsed, unlit_extension),
           "extensionsUsed: " + std::string(unlit_extension) + " and the material do not agree");
    for (const std::string& name : model.extensionsRequired)
        expect(contains(model.extensionsUsed, name), "extensionsRequired: " + name + " is not in extensionsUsed");
}

/// The rows of an accessor, aligned, and "min" and "max" as the values have them.
AccessorRows rows_of(const tinygltf::Model& model, int accessor, std::size_t components)
{
    const AccessorRows rows = gltf::accessor_rows(model, accessor, components, components);
    const auto& source = model.accessors[static_cast<std::size_t>(accessor)];
    const auto& view = model.bufferViews[static_cast<std::size_t>(source.bufferView)];
    const std::string place = entry("accessors", static_cast<std::size_t>(accessor));
    expect(view.byteOffset % 4 == 0 && source.byteOffset % 4 == 0, place + "its bytes do not start at a multiple of 4");
    expect(components == 1 || rows.stride % 4 == 0, place + "rows do not start at multiples of 4 bytes");
    if (source.minValues.empty() && source.maxValues.empty())
        return rows;
    expect(source.minValues.size() == components && source.maxValues.size() == components,
           place + "min and max: too few numbers");
    for (std::size_t c = 0; c < components; ++c)
    {
        double low = rows.at(0, c);
        double high = low;
        for (std::size_t i = 1; i < rows.count; ++i)
        {
            low = std::min(low, rows.at(i, c));
            high = std::max(high, rows.at(i, c));
        }
        expect(source.minValues[c] == low && source.maxValues[c] == high, place + "min and max differ from the values");
    }
    return rows;
}

/// The node that shows the mesh: the scene's, or its child.
const tinygltf::Node& node_of(const tinygltf::Model& model)
{
    const auto& scene = element(model.scenes, model.defaultScene, "scenes");
    const tinygltf::Node* node = &element(model.nodes, element(scene.nodes, 0, "nodes"), "nodes");
    if (node->mesh == -1)
        node = &element(model.nodes, element(node->children, 0, "children"), "nodes");
    expect(node->mesh == 0, "nodes: no node has the mesh");
    return *node;
}

double finite(const AccessorRows& rows, std::size_t row, std::size_t component)
{
    const double value = rows.at(row, component);
    expect(std::isfinite(value), fmt::format("vertex {} is not finite", row));
    return value;
}

Vec3d vector_at(const AccessorRows& rows, std::size_t row)
{
    return {finite(rows, row, 0), finite(rows, row, 1), finite(rows, row, 2)};
}

void read_positions(const AccessorRows& rows, const tinygltf::Node& node, std::vector<Vec3d>& positions)
{
    const auto vector = [](const std::vector<double>& numbers, double otherwise)
    {
        expect(numbers.empty() || numbers.size() == 3, "nodes: expected 3 numbers");
        return numbers.empty() ? Vec3d{otherwise, otherwise, otherwise} : Vec3d{numbers[0], numbers[1], numbers[2]};
    };
    const Vec3d scale = vector(node.scale, 1);
    const Vec3d origin = vector(node.translation, 0);
    for (std::size_t i = 0; i < rows.count; ++i)
    {
        const Vec3d p = vector_at(rows, i);
        positions.push_back(Vec3d{p.x * scale.x, p.y * scale.y, p.z * scale.z} + origin);
    }
}

void read_mesh(const tinygltf::Model& model, const tinygltf::Primitive& primitive, GlbModel& result)
{
    expect(primitive.mode == TINYGLTF_MODE_TRIANGLES, "primitives[0]: mode: expected triangles (4)");
    expect(primitive.attributes.contains("POSITION"), "primitives[0]: POSITION is missing");
    read_positions(rows_of(model, primitive.attributes.at("POSITION"), 3), node_of(model), result.positions);
    const auto each = [&](const std::string& name, std::size_t components, const auto& take)
    {
        const auto found = primitive.attributes.find(name);
        if (found == primitive.attributes.end())
            return;
        const AccessorRows rows = rows_of(model, found->second, components);
        expect(rows.count == result.positions.size(), name + ": expected one for each position");
        for (std::size_t i = 0; i < rows.count; ++i)
            take(rows, i);
    };
    const auto is_unit = [](Vec3d v) { return std::abs(length(v) - 1) <= unit_tolerance; };
    each("NORMAL", 3,
         [&](const AccessorRows& rows, std::size_t i)
         {
             result.normals.push_back(vector_at(rows, i));
             expect(is_unit(result.normals.back()), fmt::format("NORMAL: {} does not have unit length", i));
         });
    each("TANGENT", 4,
         [&](const AccessorRows& rows, std::size_t i)
         {
             const Vec3d along = vector_at(rows, i);
             const double side = finite(rows, i, 3);
             expect(is_unit(along) && std::abs(side) == 1,
                    fmt::format("TANGENT: {} does not have unit length and 1 or -1 behind it", i));
             result.tangents.push_back({along.x, along.y, along.z, side});
         });
    each("TEXCOORD_0", 2,
         [&](const AccessorRows& rows, std::size_t i) {
             result.texcoords.push_back({finite(rows, i, 0), finite(rows, i, 1)});
         });
    each("COLOR_0", 4,
         [&](const AccessorRows& rows, std::size_t i)
         {
             expect(rows.normalized, "COLOR_0: expected normalized integers");
             const auto step = [&](std::size_t c) { return texturing::from_linear(rows.at(i, c)); };
             result.colors.push_back({step(0), step(1), step(2)});
         });
    rows_of(model, primitive.indices, 1);
    result.indices = gltf::triangle_indices(model, primitive.indices, primitive.mode, result.positions.size());
}

std::vector<std::byte> picture_bytes(const GltfFile& gltf, std::size_t number)
{
    const auto& image = gltf.images[number];
    const std::string place = entry("images", number);
    element(gltf.model.bufferViews, image.buffer_view, "bufferViews");
    const auto bytes = std::as_bytes(gltf::view_bytes(gltf.model, static_cast<std::size_t>(image.buffer_view)));
    expect(image.mime_type == "image/png" || image.mime_type == "image/jpeg",
           place + "mimeType: expected image/png or image/jpeg");
    const std::string_view signature = image.mime_type == "image/png" ? "\x89PNG\r\n\x1a\n" : "\xFF\xD8\xFF";
    expect(bytes.size() > signature.size() &&
               std::ranges::equal(bytes.first(signature.size()), std::as_bytes(std::span(signature))),
           place + "the bytes are not " + image.mime_type);
    return {bytes.begin(), bytes.end()};
}

void read_pictures(const GltfFile& gltf, const tinygltf::Material& material, GlbModel& model)
{
    const std::array places{&model.image, &model.normal_map, &model.roughness_map};
    std::size_t next = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (textures_of(material)[i] != -1)
            *places[i] = picture_bytes(gltf, next++);
    model.image_type = gltf.images[0].mime_type;
}

}  // namespace

GlbModel read_glb(std::string_view file, std::string_view source)
{
    try
    {
        const Value document = checked_json(file);
        const auto refuse = [](const std::string&, const std::string& place) -> std::vector<std::byte>
        { throw Error(place + "uri: expected all data inside the GLB"); };
        const GltfFile gltf = gltf::load_gltf(std::as_bytes(std::span(file)), refuse);
        const auto& primitive = element(element(gltf.model.meshes, 0, "meshes").primitives, 0, "primitives");
        check_look(gltf, primitive);
        GlbModel model;
        const Value* extras = document.at("asset").find("extras");
        model.origin = extras == nullptr ? Value(Value::Map{}) : *extras;
        read_mesh(gltf.model, primitive, model);
        if (!gltf.images.empty())
            read_pictures(gltf, gltf.model.materials[static_cast<std::size_t>(primitive.material)], model);
        return model;
    }
    catch (const Error& error)
    {
        throw Error(std::string(source) + ": " + error.what());
    }
}

namespace
{

void expect_written(bool good, const std::string& what)
{
    if (!good)
        throw Error("the written file differs from what was to be written: " + what);
}

double largest(Vec3d a)
{
    return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
}

/// The first triangle whose corners are others, or follow each other differently.
void check_triangles(const std::vector<std::uint32_t>& found, const std::vector<std::uint32_t>& meant, bool may_turn)
{
    expect_written(found.size() == meant.size(), fmt::format("{} triangles of {}", found.size() / 3, meant.size() / 3));
    for (std::size_t i = 0; i < meant.size(); i += 3)
    {
        const auto same = [&](std::size_t turn) {
            return found[i] == meant[i + turn] && found[i + 1] == meant[i + (turn + 1) % 3] &&
                   found[i + 2] == meant[i + (turn + 2) % 3];
        };
        expect_written(same(0) || (may_turn && (same(1) || same(2))), fmt::format("triangle {} differs", i / 3));
    }
}

}  // namespace

GlbErrors check_glb(const GlbModel& model, const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    expect_written(model.image == image && (image.empty() || model.image_type == options.image_type), "the picture differs");
    expect_written(model.normal_map == options.relief.normals && model.roughness_map == options.relief.roughness,
                   "the relief differs");
    expect_written(model.tangents.size() == (options.material == GltfMaterial::pbr ? mesh.tangents.size() : 0),
                   "the number of tangents differs");
    expect_written(model.colors == mesh.colors, "the vertex colors differ");
    expect_written(model.texcoords.size() == mesh.texcoords.size(), "the number of texcoords differs");
    expect_written(model.positions.size() == mesh.positions.size(), "the number of vertices differs");
    expect_written(model.normals.empty() == (options.material == GltfMaterial::unlit),
                   "normals present with unlit, or missing with pbr");
    expect_written(model.origin == options.origin, "asset.extras differs");
    check_triangles(model.indices, mesh.indices, options.compress);

    // Half a step, and the rounding of this comparison itself.
    const double step = options.quantize ? double{quantized(mesh).step_m} : 0;
    const double position_limit = step * (0.5 + 1e-9);
    const double normal_limit = options.quantize ? 0.5001 / 127 : 0;
    const double texcoord_limit = options.quantize ? 0.5001 / 65535 + 1e-5 : 0;
    GlbErrors errors;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    {
        const std::string vertex = "vertex " + std::to_string(i);
        const double position = largest(model.positions[i] - vec_cast<double>(mesh.positions[i]));
        expect_written(position <= position_limit, fmt::format("{} is {:f} m away", vertex, position));
        errors.position_m = std::max(errors.position_m, position);
        if (!model.normals.empty())
            expect_written(largest(model.normals[i] - vec_cast<double>(mesh.normals[i])) <= normal_limit,
                           vertex + " has a different normal");
        for (std::size_t c = 0; c < 4 && !model.tangents.empty(); ++c)
            expect_written(std::abs(model.tangents[i][c] - double{mesh.tangents[i][c]}) <= normal_limit,
                           vertex + " has a different tangent");
        if (mesh.texcoords.empty())
            continue;
        const Vec2f uv = mesh.texcoords[i];
        // The float that 1 - v is, where floats are written.
        const double v = options.quantize ? 1 - double{uv.y} : double{1 - uv.y};
        const double texcoord = std::max(std::abs(model.texcoords[i].x - double{uv.x}), std::abs(model.texcoords[i].y - v));
        expect_written(texcoord <= texcoord_limit, vertex + " has a different texcoord");
        errors.texcoord = std::max(errors.texcoord, texcoord);
    }
    return errors;
}
