#include "glb.h"

#include "compression.h"
#include "gltf_names.h"
#include "quantized_mesh.h"

#include <fresco/error.h>
#include <fresco/texturing/linear_light.h>
#include <fresco/value.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

using namespace fresco;
using fresco::texturing::WeldedMesh;

namespace
{
constexpr std::size_t largest_file = std::numeric_limits<std::uint32_t>::max() - 65536;  // leaves room for the JSON part

/// Restarts strips in graphics hardware: no vertex has this number.
constexpr std::size_t restart_index = 65535;

void append(std::vector<std::byte>& to, std::span<const std::byte> bytes)
{
    to.insert(to.end(), bytes.begin(), bytes.end());
    to.resize((to.size() + 3) / 4 * 4);
}

void append_word(std::vector<std::byte>& to, std::size_t word)
{
    for (unsigned shift = 0; shift < 32; shift += 8)
        to.push_back(static_cast<std::byte>(word >> shift & 0xFFU));
}

template <std::size_t N, class T>
Value::List list_of(const std::array<T, N>& values)
{
    return Value::List(values.begin(), values.end());
}

/// How an accessor is to be read.
struct Layout
{
    int component_type = gltf::float32;
    const char* type = "SCALAR";
    std::size_t stride = 0;  ///< Bytes from row to row.
    bool normalized = false;
};

/// Fills buffer views and accessors; every view begins at a multiple of four. Compressed views lie in buffer 0 as they are
/// stored, and in buffer 1, which no file holds, as they are read.
class Buffers
{
  public:
    explicit Buffers(bool compress) : compress_(compress) {}

    std::size_t add_rows(std::span<const std::byte> rows, const Layout& layout, Value bounds = {})
    {
        const std::size_t count = rows.size() / layout.stride;
        Value view = compress_ ? compressed_view(compressed_rows(rows, layout.stride), count, layout.stride, "ATTRIBUTES")
                               : plain_view(rows);
        if (compress_ || layout.component_type != gltf::float32)
            view.set("byteStride", layout.stride);
        view.set("target", gltf::array_buffer);
        return add_accessor(std::move(view), count, layout, std::move(bounds));
    }

    std::size_t add_indices(const std::vector<std::uint32_t>& indices, std::size_t vertices)
    {
        const bool is_short = vertices <= restart_index;
        const Layout layout{is_short ? gltf::uint16 : gltf::uint32, "SCALAR", is_short ? 2U : 4U, false};
        Value view;
        if (compress_)
            view = compressed_view(compressed_triangles(indices, vertices), indices.size(), layout.stride, "TRIANGLES");
        else if (is_short)
        {
            const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
            view = plain_view(std::as_bytes(std::span(narrow)));
        }
        else
            view = plain_view(std::as_bytes(std::span(indices)));
        view.set("target", gltf::element_array_buffer);
        return add_accessor(std::move(view), indices.size(), layout, {});
    }

    std::size_t add_picture(std::span<const std::byte> bytes)
    {
        views_.emplace_back(plain_view(bytes));
        return views_.size() - 1;
    }

    /// Moves what was collected into the document and returns the binary part.
    std::vector<std::byte> finish(Value& document)
    {
        Value::List buffers{Value::Map{{"byteLength", binary_.size()}}};
        if (compress_)
            buffers.emplace_back(Value::Map{{"byteLength", restored_bytes_},
                                            {"extensions", Value::Map{{gltf::meshopt, Value::Map{{"fallback", true}}}}}});
        document.set("accessors", std::move(accessors_));
        document.set("bufferViews", std::move(views_));
        document.set("buffers", std::move(buffers));
        return std::move(binary_);
    }

  private:
    Value plain_view(std::span<const std::byte> bytes)
    {
        const std::size_t offset = binary_.size();
        append(binary_, bytes);
        return Value::Map{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}};
    }

    Value compressed_view(std::span<const std::byte> stream, std::size_t count, std::size_t stride, const char* mode)
    {
        Value stored = plain_view(stream);
        stored.set("byteStride", stride);
        stored.set("count", count);
        stored.set("mode", mode);
        const std::size_t offset = restored_bytes_;
        restored_bytes_ = (offset + count * stride + 3) / 4 * 4;
        return Value::Map{{"buffer", 1},
                          {"byteOffset", offset},
                          {"byteLength", count * stride},
                          {"extensions", Value::Map{{gltf::meshopt, std::move(stored)}}}};
    }

    std::size_t add_accessor(Value view, std::size_t count, const Layout& layout, Value bounds)
    {
        views_.push_back(std::move(view));
        Value accessor = Value::Map{
            {"bufferView", views_.size() - 1}, {"componentType", layout.component_type}, {"count", count}, {"type", layout.type}};
        if (layout.normalized)
            accessor.set("normalized", true);
        if (!bounds.is_null())
            for (const auto& [key, value] : bounds.as_map())
                accessor.set(key, value);
        accessors_.push_back(std::move(accessor));
        return accessors_.size() - 1;
    }

    bool compress_;
    std::vector<std::byte> binary_;
    std::size_t restored_bytes_ = 0;
    Value::List views_;
    Value::List accessors_;
};

/// "min" and "max" of the first three numbers of each row.
template <class Number, class Row>
Value bounds_of(const std::vector<Row>& rows, const auto& component)
{
    std::array<Number, 3> low{};
    std::array<Number, 3> high{};
    for (std::size_t i = 0; i < 3; ++i)
    {
        low[i] = high[i] = static_cast<Number>(component(rows.front(), i));
        for (const Row& row : rows)
        {
            low[i] = std::min(low[i], static_cast<Number>(component(row, i)));
            high[i] = std::max(high[i], static_cast<Number>(component(row, i)));
        }
    }
    return Value::Map{{"min", list_of(low)}, {"max", list_of(high)}};
}

/// Linear light in 16 bits, from which every step of sRGB comes back.
void add_colors(Buffers& buffers, const WeldedMesh& mesh, Value::Map& attributes)
{
    if (mesh.colors.empty())
        return;
    std::vector<std::array<std::uint16_t, 4>> rows;
    for (const Rgb8& color : mesh.colors)
    {
        const auto light = [](std::uint8_t step)
        { return static_cast<std::uint16_t>(std::lround(texturing::to_linear(step) * 65535)); };
        rows.push_back({light(color[0]), light(color[1]), light(color[2]), 65535});
    }
    attributes.emplace_back("COLOR_0", buffers.add_rows(std::as_bytes(std::span(rows)), {gltf::uint16, "VEC4", 8, true}));
}

Value::Map add_plain(Buffers& buffers, const WeldedMesh& mesh, bool has_normals)
{
    const auto rows = [](const auto& values) { return std::as_bytes(std::span(values)); };
    const auto axis = [](Vec3f p, std::size_t i) { return i == 0 ? p.x : i == 1 ? p.y : p.z; };
    const Layout vec3{gltf::float32, "VEC3", sizeof(Vec3f), false};
    Value::Map attributes{{"POSITION", buffers.add_rows(rows(mesh.positions), vec3, bounds_of<double>(mesh.positions, axis))}};
    if (has_normals)
        attributes.emplace_back("NORMAL", buffers.add_rows(rows(mesh.normals), vec3));
    std::vector<Vec2f> flipped = mesh.texcoords;
    for (Vec2f& uv : flipped)
        uv.y = 1 - uv.y;
    if (!flipped.empty())
        attributes.emplace_back("TEXCOORD_0", buffers.add_rows(rows(flipped), {gltf::float32, "VEC2", sizeof(Vec2f), false}));
    return attributes;
}

Value::Map add_quantized(Buffers& buffers, const QuantizedMesh& mesh, bool has_normals)
{
    const auto rows = [](const auto& values) { return std::as_bytes(std::span(values)); };
    const auto axis = [](const auto& row, std::size_t i) { return row[i]; };
    Value::Map attributes{{"POSITION", buffers.add_rows(rows(mesh.positions), {gltf::uint16, "VEC3", 8, false},
                                                        bounds_of<int>(mesh.positions, axis))}};
    if (has_normals)
        attributes.emplace_back("NORMAL", buffers.add_rows(rows(mesh.normals), {gltf::int8, "VEC3", 4, true}));
    if (!mesh.texcoords.empty())
        attributes.emplace_back("TEXCOORD_0", buffers.add_rows(rows(mesh.texcoords), {gltf::uint16, "VEC2", 4, true}));
    return attributes;
}

/// The parent turns the world upright, the child takes whole steps to meters.
Value::List nodes_of(GltfUp up, const QuantizedMesh* quantized)
{
    const double half = std::sqrt(0.5);
    Value shown = Value::Map{{"name", "room"}, {"mesh", 0}};
    if (quantized != nullptr)
    {
        const Vec3d origin = vec_cast<double>(quantized->origin);
        const double step = double{quantized->step_m};
        shown.set("translation", Value::List{origin.x, origin.y, origin.z});
        shown.set("scale", Value::List{step, step, step});
    }
    if (up == GltfUp::keep)
        return {shown};
    // x, y, z, w: a quarter turn about -X, or half a turn about X.
    const Value rotation = up == GltfUp::z ? Value::List{-half, 0.0, 0.0, half} : Value::List{1.0, 0.0, 0.0, 0.0};
    if (quantized == nullptr)
    {
        shown.set("rotation", rotation);
        return {shown};
    }
    return {Value::Map{{"name", "upright"}, {"rotation", rotation}, {"children", Value::List{1}}}, shown};
}

void add_material(Value& document, bool has_picture, const GlbOptions& options)
{
    Value pbr = Value::Map{{"metallicFactor", 0}, {"roughnessFactor", 1}};
    if (has_picture)
        pbr.set("baseColorTexture", Value::Map{{"index", 0}});
    Value material = Value::Map{{"name", "texture"}, {"pbrMetallicRoughness", std::move(pbr)}};
    if (options.material == GltfMaterial::unlit)
        material.set("extensions", Value::Map{{gltf::unlit, Value::Map{}}});
    document.set("materials", Value::List{material});
}

void add_texture(Value& document, std::size_t picture_view, const GlbOptions& options)
{
    document.set("textures", Value::List{Value::Map{{"sampler", 0}, {"source", 0}}});
    document.set("images", Value::List{Value::Map{{"bufferView", picture_view}, {"mimeType", options.image_type}}});
    document.set("samplers", Value::List{Value::Map{{"magFilter", gltf::linear},
                                                    {"minFilter", gltf::linear_mipmap_linear},
                                                    {"wrapS", gltf::clamp_to_edge},
                                                    {"wrapT", gltf::clamp_to_edge}}});
}

void declare_extensions(Value& document, const GlbOptions& options)
{
    Value::List required;
    if (options.quantize)
        required.emplace_back(gltf::quantization);
    if (options.compress)
        required.emplace_back(gltf::meshopt);
    Value::List used = required;
    if (options.material == GltfMaterial::unlit)
        used.emplace_back(gltf::unlit);
    if (!used.empty())
        document.set("extensionsUsed", used);
    if (!required.empty())
        document.set("extensionsRequired", required);
}

std::vector<std::byte> assembled(const Value& document, const std::vector<std::byte>& binary)
{
    std::string text = to_json(document);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> glb;
    const std::size_t total = 12 + 8 + text.size() + 8 + binary.size();
    glb.reserve(total);
    append_word(glb, gltf::magic);
    append_word(glb, 2);
    append_word(glb, total);
    append_word(glb, text.size());
    append_word(glb, gltf::json_chunk);
    append(glb, std::as_bytes(std::span(text)));
    append_word(glb, binary.size());
    append_word(glb, gltf::binary_chunk);
    append(glb, binary);
    return glb;
}
}  // namespace

std::vector<std::byte> make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    const std::size_t bytes = mesh.indices.size() * 4 + mesh.positions.size() * 40 + image.size();
    if (bytes > largest_file)
        throw Error("the mesh and its picture take " + std::to_string(bytes >> 20U) +
                    " MiB, a GLB file holds at most 4096: decimate the mesh or set max_texture_px");
    const bool has_normals = options.material == GltfMaterial::pbr;
    const QuantizedMesh steps = options.quantize ? quantized(mesh) : QuantizedMesh{};
    Buffers buffers(options.compress);
    const std::size_t indices = buffers.add_indices(mesh.indices, mesh.positions.size());
    Value::Map attributes = options.quantize ? add_quantized(buffers, steps, has_normals) : add_plain(buffers, mesh, has_normals);
    add_colors(buffers, mesh, attributes);
    const Value primitive =
        Value::Map{{"attributes", std::move(attributes)}, {"indices", indices}, {"material", 0}, {"mode", gltf::triangles}};

    Value document = Value::Map{{"asset", Value::Map{{"version", "2.0"}, {"generator", "fresco"}}}};
    declare_extensions(document, options);
    document.set("scene", 0);
    document.set("scenes", Value::List{Value::Map{{"nodes", Value::List{0}}}});
    document.set("nodes", nodes_of(options.up, options.quantize ? &steps : nullptr));
    document.set("meshes", Value::List{Value::Map{{"name", "room"}, {"primitives", Value::List{primitive}}}});
    add_material(document, !image.empty(), options);
    if (!image.empty())
        add_texture(document, buffers.add_picture(image), options);
    const std::vector<std::byte> binary = buffers.finish(document);
    return assembled(document, binary);
}
