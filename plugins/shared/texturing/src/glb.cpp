#include <fresco/texturing/glb.h>

#include <fresco/error.h>
#include <fresco/texturing/texture_pictures.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace fresco::texturing
{

namespace
{

constexpr std::size_t largest_file = std::numeric_limits<std::uint32_t>::max() - (1U << 20U);  // leaves room for the JSON part

/// Graphics hardware restarts strips at this index, so no vertex has this number.
constexpr std::size_t restart_index = 65535;

// glTF's numbers for how a buffer is used and for types of components.
constexpr int array_buffer = 34962;
constexpr int element_array_buffer = 34963;
constexpr int type_uint16 = 5123;
constexpr int type_uint32 = 5125;
constexpr int type_float = 5126;

/// The lists of a glTF document that grow together. Each entry of Value::Map is in the order of its key.
class Document
{
  public:
    /// Appends bytes to the buffer, at a multiple of four, and a view of them. Returns the view's number.
    std::size_t add_view(std::span<const std::byte> bytes, int target = 0, std::size_t stride = 0)
    {
        Value view = Value::Map{{"buffer", 0}, {"byteLength", bytes.size()}};
        if (!binary_.empty())
            view.set("byteOffset", binary_.size());
        if (stride != 0)
            view.set("byteStride", stride);
        if (target != 0)
            view.set("target", target);
        views_.push_back(std::move(view));
        binary_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        binary_.resize((binary_.size() + 3) / 4 * 4);
        return views_.size() - 1;
    }

    /// Appends rows of `Row` and their accessor. Returns the accessor's number.
    template <class Row>
    std::size_t add_rows(const std::vector<Row>& rows, int component_type, const char* type)
    {
        const bool is_float = component_type == type_float;
        const std::size_t view = add_view(std::as_bytes(std::span(rows)), array_buffer, is_float ? 0 : sizeof(Row));
        Value accessor = Value::Map{{"bufferView", view}, {"componentType", component_type}, {"count", rows.size()}};
        if (!is_float)
            accessor.set("normalized", true);
        return add_accessor(std::move(accessor), type);
    }

    std::size_t add_positions(const std::vector<Vec3f>& positions)
    {
        const std::size_t view = add_view(std::as_bytes(std::span(positions)), array_buffer);
        Value::List low;
        Value::List high;
        for (const auto member : {&Vec3f::x, &Vec3f::y, &Vec3f::z})
        {
            const auto [least, most] = std::ranges::minmax(positions, {}, member);
            low.emplace_back(double{least.*member});
            high.emplace_back(double{most.*member});
        }
        return add_accessor(Value::Map{{"bufferView", view},
                                       {"componentType", type_float},
                                       {"count", positions.size()},
                                       {"max", std::move(high)},
                                       {"min", std::move(low)}},
                            "VEC3");
    }

    template <class Index>
    std::size_t add_indices(const std::vector<Index>& indices)
    {
        const std::size_t view = add_view(std::as_bytes(std::span(indices)), element_array_buffer);
        return add_accessor(Value::Map{{"bufferView", view},
                                       {"componentType", sizeof(Index) == 2 ? type_uint16 : type_uint32},
                                       {"count", indices.size()}},
                            "SCALAR");
    }

    /// The GLB: the document of these entries and the lists, and the buffer.
    std::string glb(const Value& asset, const Value::Map& others) const
    {
        Value::Map document{{"accessors", accessors_},
                            {"asset", asset},
                            {"bufferViews", views_},
                            {"buffers", Value::List{Value::Map{{"byteLength", binary_.size()}}}}};
        document.insert(document.end(), others.begin(), others.end());
        return glb_of(document, binary_);
    }

  private:
    std::size_t add_accessor(Value accessor, const char* type)
    {
        accessor.set("type", type);
        accessors_.push_back(std::move(accessor));
        return accessors_.size() - 1;
    }

    Value::List accessors_;
    Value::List views_;
    std::string binary_;
};

/// Linear light in 16 bits, from which every step of sRGB comes back.
std::vector<std::array<std::uint16_t, 4>> linear_colors(const WeldedMesh& mesh)
{
    std::vector<std::array<std::uint16_t, 4>> rows;
    const auto light = [](std::uint8_t step) { return static_cast<std::uint16_t>(std::lround(to_linear(step) * 65535)); };
    for (const Rgb8& color : mesh.colors)
        rows.push_back({light(color[0]), light(color[1]), light(color[2]), 65535});
    return rows;
}

/// Adds the mesh. Returns the primitive that has the only material.
Value add_mesh(Document& document, const WeldedMesh& mesh, bool lit)
{
    const bool is_large = mesh.positions.size() > restart_index;
    const std::size_t indices = is_large
                                    ? document.add_indices(mesh.indices)
                                    : document.add_indices(std::vector<std::uint16_t>(mesh.indices.begin(), mesh.indices.end()));
    Value attributes = Value::Map{};
    const std::size_t position = document.add_positions(mesh.positions);
    const std::size_t normal = lit ? document.add_rows(mesh.normals, type_float, "VEC3") : 0;
    const bool has_tangents = lit && !mesh.tangents.empty();
    const std::size_t tangent = has_tangents ? document.add_rows(mesh.tangents, type_float, "VEC4") : 0;
    std::vector<Vec2f> flipped = mesh.texcoords;
    for (Vec2f& uv : flipped)
        uv.y = 1 - uv.y;
    const std::size_t texcoord = flipped.empty() ? 0 : document.add_rows(flipped, type_float, "VEC2");
    if (!mesh.colors.empty())
        attributes.set("COLOR_0", document.add_rows(linear_colors(mesh), type_uint16, "VEC4"));
    if (lit)
        attributes.set("NORMAL", normal);
    attributes.set("POSITION", position);
    if (has_tangents)
        attributes.set("TANGENT", tangent);
    if (!flipped.empty())
        attributes.set("TEXCOORD_0", texcoord);
    return Value::Map{{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"mode", 4}};
}

}  // namespace

std::string glb_of(const Value& document, std::string_view binary)
{
    std::string json = to_json(document);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    if (json.size() + binary.size() > std::numeric_limits<std::uint32_t>::max() - 28)
        throw Error("a GLB file holds at most 4096 MiB: use fewer or smaller pictures, or decimate the mesh");
    const auto words = [](auto... numbers)
    {
        const std::array<std::uint32_t, sizeof...(numbers)> row{static_cast<std::uint32_t>(numbers)...};
        return std::string(reinterpret_cast<const char*>(row.data()), sizeof row);
    };
    std::string file = "glTF" + words(2, 28 + json.size() + binary.size(), json.size()) + "JSON" + json + words(binary.size()) +
                       std::string("BIN\0", 4);
    file += binary;
    return file;
}

Value origin_of(const Mesh& mesh, RunContext& run)
{
    Value origin = run.origin();
    const Vec3d offset_m = mesh.offset_m;
    if (offset_m != Vec3d{})
        origin.set("offset_m", Value::List{offset_m.x, offset_m.y, offset_m.z});
    tell_offset(offset_m, run);
    return origin;
}

std::string make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    const std::size_t bytes = mesh.indices.size() * 4 + mesh.positions.size() * 56 + image.size() +
                              options.relief.normals.size() + options.relief.roughness.size();
    if (bytes > largest_file)
        throw Error(fmt::format(
            "the mesh and its picture take {} MiB; a GLB file holds at most 4096: decimate the mesh or set max_texture_px",
            bytes >> 20U));
    Document document;
    const Value primitive = add_mesh(document, mesh, options.lit);

    Value::List images;
    Value::List textures;
    const auto add_texture = [&](const std::vector<std::byte>& picture) -> Value
    {
        images.push_back(Value::Map{{"bufferView", document.add_view(picture)}, {"mimeType", options.image_type}});
        textures.push_back(Value::Map{{"sampler", 0}, {"source", images.size() - 1}});
        return Value::Map{{"index", images.size() - 1}};
    };
    Value material = Value::Map{};
    Value roughness = Value::Map{};
    if (!options.lit)
        material.set("extensions", Value::Map{{"KHR_materials_unlit", Value::Map{}}});
    material.set("name", "texture");
    if (!image.empty())
        roughness.set("baseColorTexture", add_texture(image));
    roughness.set("metallicFactor", 0.0);
    if (!options.relief.normals.empty())
    {
        material.set("normalTexture", add_texture(options.relief.normals));
        roughness.set("metallicRoughnessTexture", add_texture(options.relief.roughness));
    }
    material.set("pbrMetallicRoughness", std::move(roughness));

    Value node = Value::Map{{"mesh", 0}, {"name", "room"}};
    if (options.turn != std::array<double, 4>{0, 0, 0, 1})
        node.set("rotation", Value::List(options.turn.begin(), options.turn.end()));
    Value asset = Value::Map{{"generator", "fresco"}, {"version", "2.0"}};
    if (!options.origin.as_map().empty())
        asset.set("extras", options.origin);
    Value others = Value::Map{};
    if (!options.lit)
        others.set("extensionsUsed", Value::List{"KHR_materials_unlit"});
    if (!images.empty())
        others.set("images", std::move(images));
    others.set("materials", Value::List{std::move(material)});
    others.set("meshes", Value::List{Value::Map{{"name", "room"}, {"primitives", Value::List{primitive}}}});
    others.set("nodes", Value::List{std::move(node)});
    constexpr int linear = 9729;
    constexpr int linear_mipmap_linear = 9987;
    constexpr int clamp_to_edge = 33071;
    if (!textures.empty())
        others.set(
            "samplers",
            Value::List{Value::Map{
                {"magFilter", linear}, {"minFilter", linear_mipmap_linear}, {"wrapS", clamp_to_edge}, {"wrapT", clamp_to_edge}}});
    others.set("scene", 0);
    others.set("scenes", Value::List{Value::Map{{"nodes", Value::List{0}}}});
    if (!textures.empty())
        others.set("textures", std::move(textures));
    return document.glb(asset, others.as_map());
}

}  // namespace fresco::texturing
