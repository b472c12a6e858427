#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/gltf/model_folder.h>
#include <fresco/gltf/scene.h>
#include <fresco/texturing/glb.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

namespace export_model
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::Value;
using fresco::Vec2f;
using fresco::gltf::accessor_rows;
using fresco::gltf::AccessorRows;
using fresco::gltf::entry;
using fresco::gltf::GltfFile;

namespace
{

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
/// Graphics hardware restarts strips at this index, so no vertex has this number.
constexpr std::size_t restart_index = 65535;
constexpr int array_buffer = 34962;
constexpr int element_array_buffer = 34963;
constexpr std::string_view meshopt = "EXT_meshopt_compression";
constexpr std::string_view draco = "KHR_draco_mesh_compression";
constexpr std::string_view instancing = "EXT_mesh_gpu_instancing";
constexpr std::string_view emissive_strength = "KHR_materials_emissive_strength";
constexpr std::string_view specular_glossiness = "KHR_materials_pbrSpecularGlossiness";

/// The list of a document, made if it is not there.
Value::List& list_of(Value& document, std::string_view key)
{
    if (document.find(key) == nullptr)
        document.set(key, Value::List{});
    return document.find(key)->as_list();
}

void remove(Value& map, std::string_view key)
{
    std::erase_if(map.as_map(), [&](const Value::Entry& each) { return each.first == key; });
}

/// The entry of an extension, or null.
Value* extension_of(Value& map, std::string_view name)
{
    Value* const extensions = map.find("extensions");
    return extensions == nullptr ? nullptr : extensions->find(name);
}

void remove_extension(Value& map, std::string_view name)
{
    Value* const extensions = map.find("extensions");
    if (extensions == nullptr)
        return;
    remove(*extensions, name);
    if (extensions->as_map().empty())
        remove(map, "extensions");
}

int index_or(const Value& map, std::string_view key, int otherwise)
{
    const Value* const found = map.find(key);
    return found == nullptr ? otherwise : static_cast<int>(found->as_int());
}

template <class Visit>
void visit_entries(Value& value, const Visit& visit);

template <class Visit>
void visit_entries(Value::List& values, const Visit& visit)
{
    for (Value& each : values)
        visit_entries(each, visit);
}

/// Calls `visit(key, value)` for all entries of maps at any depth but extras.
template <class Visit>
void visit_entries(Value& value, const Visit& visit)
{
    if (value.is_list())
        visit_entries(value.as_list(), visit);
    else if (value.is_map())
        for (auto& [key, inner] : value.as_map())
            if (key != "extras")
            {
                visit(key, inner);
                visit_entries(inner, visit);
            }
}

/// Removes the entries of a list whose numbers are in `gone`. Returns the new number of each.
std::vector<std::int64_t> removed(Value::List& list, const std::set<std::int64_t>& gone)
{
    std::vector<std::int64_t> numbers;
    Value::List kept;
    for (std::size_t i = 0; i < list.size(); ++i)
    {
        numbers.push_back(static_cast<std::int64_t>(kept.size()));
        if (!gone.contains(static_cast<std::int64_t>(i)))
            kept.push_back(std::move(list[i]));
    }
    list = std::move(kept);
    return numbers;
}

/// A primitive's vertices once every one of them has a single new texcoord.
struct SplitVertices
{
    std::vector<std::uint32_t> source;  ///< The old vertex of each; the old ones come first, in their order.
    std::vector<Vec2f> texcoords;
    std::vector<std::uint32_t> corners;
};

/// `texcoords`: one per corner. Corners of triangles that are not painted take part with any texcoord of their vertex.
SplitVertices split_vertices(const std::vector<std::uint32_t>& corners, const std::vector<Vec2f>& texcoords,
                             const std::vector<bool>& painted, std::size_t vertices)
{
    SplitVertices split;
    split.source.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v)
        split.source[v] = static_cast<std::uint32_t>(v);
    split.texcoords.resize(vertices);
    split.corners = corners;
    std::vector<bool> has_texcoord(vertices, false);
    std::vector<std::uint32_t> next(vertices, none);
    for (std::size_t corner = 0; corner < corners.size(); ++corner)
    {
        if (!painted[corner / 3])
            continue;
        std::uint32_t v = corners[corner];
        if (!has_texcoord[v])
        {
            split.texcoords[v] = texcoords[corner];
            has_texcoord[v] = true;
        }
        while (split.texcoords[v] != texcoords[corner] && next[v] != none)
            v = next[v];
        if (split.texcoords[v] != texcoords[corner])
        {
            next[v] = static_cast<std::uint32_t>(split.source.size());
            v = next[v];
            next.push_back(none);
            split.source.push_back(corners[corner]);
            split.texcoords.push_back(texcoords[corner]);
        }
        split.corners[corner] = v;
    }
    return split;
}

template <class T>
std::vector<unsigned char> bytes_of(const std::vector<T>& rows)
{
    const auto* const begin = reinterpret_cast<const unsigned char*>(rows.data());
    return {begin, begin + rows.size() * sizeof(T)};
}

class GltfPainter
{
  public:
    GltfPainter(GltfFile file, const fs::path& path, const Painting& painting, PaintedFiles& result)
        : file_(std::move(file)), document_(file_.document), path_(path), painting_(painting), result_(result),
          originals_(list_of(document_, "materials"))
    {
    }

    std::string glb()
    {
        find_painted();
        check_faces(path_, face_uses_, painting_);
        count_accessors();
        add_picture();
        for (const PaintedPrimitive& each : primitives_)
            paint(each);
        remove_old_pictures();
        if (!uses_draco())
            for (const char* const list : {"extensionsUsed", "extensionsRequired"})
                if (Value* const names = document_.find(list))
                    std::erase(names->as_list(), Value(draco));
        embed_images();
        remove_unused_views();
        add_origin();
        return packed();
    }

  private:
    struct PaintedPrimitive
    {
        std::size_t mesh = 0;
        std::size_t primitive = 0;
        std::vector<std::uint32_t> corners;
        std::vector<Vec2f> texcoords;  ///< One per corner.
        std::vector<bool> painted;     ///< One per triangle: those that name a vertex twice are not in the atlas.
    };

    Value& json_of(const PaintedPrimitive& each)
    {
        return list_of(document_, "meshes")[each.mesh].find("primitives")->as_list()[each.primitive];
    }

    /// Gives every node of the scene a mesh of its own, since the copies of a mesh have different places in the picture, and
    /// walks over the faces in the reader's order.
    void find_painted()
    {
        std::set<std::size_t> used;
        for (const auto& [node, place] : fresco::gltf::placed_nodes(file_.model))
        {
            if (file_.model.nodes[node].mesh < 0)
                continue;
            auto mesh = static_cast<std::size_t>(file_.model.nodes[node].mesh);
            if (!painting_.keeps_uvs && extension_of(list_of(document_, "nodes")[node], instancing) != nullptr)
                throw Error(path_.string() + ": " + entry("nodes", node) +
                            "the copies of EXT_mesh_gpu_instancing share their texture coordinates, so they cannot be painted "
                            "one by one; set uvs: new, or export the model without it");
            if (!painting_.keeps_uvs && !used.insert(mesh).second)
            {
                Value::List& meshes = list_of(document_, "meshes");
                meshes.push_back(Value(meshes[mesh]));
                file_.model.meshes.push_back(tinygltf::Mesh(file_.model.meshes[mesh]));
                mesh = meshes.size() - 1;
                list_of(document_, "nodes")[node].set("mesh", mesh);
            }
            for (std::size_t i = 0; i < file_.model.meshes[mesh].primitives.size(); ++i)
                find_painted(mesh, i, determinant(place.linear) < 0);
        }
    }

    void find_painted(std::size_t mesh, std::size_t number, bool mirrored)
    {
        const tinygltf::Primitive& primitive = file_.model.meshes[mesh].primitives[number];
        const auto positions = primitive.attributes.find("POSITION");
        const std::size_t vertices = accessor_rows(file_.model, positions->second, 3, 3).count;
        PaintedPrimitive each{
            mesh, number, fresco::gltf::triangle_indices(file_.model, primitive.indices, primitive.mode, vertices), {}, {}};
        if (each.corners.empty())
            return;
        const Value* const mode =
            primitive.material < 0 ? nullptr : originals_.at(static_cast<std::size_t>(primitive.material)).find("alphaMode");
        const bool is_cutout = mode != nullptr && mode->as_string() != "OPAQUE";
        each.texcoords.resize(each.corners.size());
        for (std::size_t i = 0; i < each.corners.size(); i += 3)
        {
            const std::uint32_t* const t = &each.corners[i];
            each.painted.push_back(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            if (!each.painted.back())
                continue;
            // The reader turns the faces of mirrored nodes by swapping their last two corners.
            for (std::size_t k = 0; k < 3 && 3 * face_uses_ + k < painting_.atlas.texcoords.size(); ++k)
                each.texcoords[i + (mirrored && k > 0 ? 3 - k : k)] = painting_.atlas.texcoords[3 * face_uses_ + k];
            cutout_.push_back(is_cutout);
            ++face_uses_;
        }
        has_cutout_ = has_cutout_ || is_cutout;
        painted_uses_.emplace(mesh, number);
        primitives_.push_back(std::move(each));
    }

    template <class Visit>
    void visit_accessors(Value& primitive, const Visit& visit)
    {
        for (auto& [name, accessor] : primitive.find("attributes")->as_map())
            visit(accessor);
        if (Value* const targets = primitive.find("targets"))
            for (Value& target : targets->as_list())
                for (auto& [name, accessor] : target.as_map())
                    visit(accessor);
    }

    void count_accessors()
    {
        for (Value& mesh : list_of(document_, "meshes"))
            for (Value& primitive : mesh.find("primitives")->as_list())
            {
                visit_accessors(primitive, [&](const Value& accessor) { ++accessor_uses_[accessor.as_int()]; });
                ++accessor_uses_[index_or(primitive, "indices", -1)];
            }
    }

    // --- pictures and materials

    void add_picture()
    {
        const Picture picture = painting_.picture(has_cutout_ ? cutout_ : std::vector<bool>{});
        Value::List& images = list_of(document_, "images");
        images.push_back(
            Value::Map{{"bufferView", add_view(std::vector<unsigned char>(
                                          reinterpret_cast<const unsigned char*>(picture.bytes.data()),
                                          reinterpret_cast<const unsigned char*>(picture.bytes.data()) + picture.bytes.size()))},
                       {"mimeType", picture.extension == ".jpg" ? "image/jpeg" : "image/png"}});
        Value texture = Value::Map{{"source", images.size() - 1}};
        constexpr int linear = 9729;
        constexpr int linear_mipmap_linear = 9987;
        constexpr int clamp_to_edge = 33071;
        Value::List& samplers = list_of(document_, "samplers");
        samplers.push_back(Value::Map{
            {"magFilter", linear}, {"minFilter", linear_mipmap_linear}, {"wrapS", clamp_to_edge}, {"wrapT", clamp_to_edge}});
        texture.set("sampler", samplers.size() - 1);
        Value::List& textures = list_of(document_, "textures");
        textures.push_back(std::move(texture));
        texture_ = textures.size() - 1;
    }

    /// The number of the painted form of a material that finds the picture by the texcoords `set`. Materials that something else
    /// uses, too, are copied.
    std::size_t painted_material(int material, int set)
    {
        const auto [found, is_new] = painted_materials_.try_emplace({material, set}, 0);
        if (!is_new)
            return found->second;
        Value::List& materials = list_of(document_, "materials");
        const auto number = static_cast<std::size_t>(material);
        const bool is_copied = material < 0 || is_used_unpainted(material) || !changed_materials_.insert(material).second;
        found->second = is_copied ? materials.size() : number;
        if (is_copied)
            materials.push_back(material < 0 ? Value(Value::Map{}) : originals_.at(number));
        paint_material(materials[found->second], set);
        return found->second;
    }

    bool is_used_unpainted(int material) const
    {
        const auto& meshes = file_.model.meshes;
        for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh)
            for (std::size_t i = 0; i < meshes[mesh].primitives.size(); ++i)
                if (meshes[mesh].primitives[i].material == material && !painted_uses_.contains({mesh, i}))
                    return true;
        return false;
    }

    void paint_material(Value& material, int set)
    {
        Value* const older = extension_of(material, specular_glossiness);
        Value* pbr = material.find("pbrMetallicRoughness");
        if (shows_emission(material, older != nullptr ? older : pbr, older != nullptr ? "diffuse" : "baseColor"))
        {
            paint_color(material, "emissiveTexture", "emissiveFactor", set);
            remove_extension(material, emissive_strength);
            return;
        }
        if (older != nullptr)
            paint_color(*older, "diffuseTexture", "diffuseFactor", set);
        if (pbr == nullptr && older == nullptr)
        {
            material.set("pbrMetallicRoughness", Value::Map{});
            pbr = material.find("pbrMetallicRoughness");
        }
        if (pbr != nullptr)
            paint_color(*pbr, "baseColorTexture", "baseColorFactor", set);
    }

    /// Whether scan.mesh took the emission for the material's color: it shines, and its color is black or, beside a picture that
    /// shines, a plain white.
    static bool shows_emission(const Value& material, const Value* colors, const std::string& name)
    {
        const auto all_are = [](const Value* factor, double value)
        {
            for (std::size_t i = 0; factor != nullptr && i < 3; ++i)
                if (factor->as_list().at(i).as_double() != value)
                    return false;
            return factor != nullptr;
        };
        const Value* const factor = material.find("emissiveFactor");
        if (factor == nullptr || all_are(factor, 0))
            return false;
        const Value* const base = colors == nullptr ? nullptr : colors->find(name + "Factor");
        const bool is_plain =
            (colors == nullptr || colors->find(name + "Texture") == nullptr) && (base == nullptr || all_are(base, 1));
        return all_are(base, 0) || (is_plain && material.find("emissiveTexture") != nullptr);
    }

    /// The factor keeps its alpha: its color went into the painting.
    void paint_color(Value& map, const char* texture_key, const char* factor_key, int set)
    {
        Value info = Value::Map{};
        if (const Value* const old = map.find(texture_key))
        {
            old_textures_.insert(old->at("index").as_int());
            if (painting_.keeps_uvs)
                info = *old;
        }
        info.set("index", texture_);
        if (set > 0)
            info.set("texCoord", set);
        map.set(texture_key, std::move(info));
        if (const Value* const factor = map.find(factor_key))
        {
            Value::List white{1.0, 1.0, 1.0};
            for (std::size_t i = 3; i < factor->as_list().size(); ++i)
                white.push_back(factor->as_list()[i]);
            map.set(factor_key, std::move(white));
        }
    }

    /// Removes the textures that the painted materials showed, and their pictures, unless something else shows them, too.
    void remove_old_pictures()
    {
        std::set<std::int64_t> gone = old_textures_;
        const auto visit_textures = [&](const auto& visit)
        {
            visit_entries(list_of(document_, "materials"),
                          [&](const std::string& key, Value& value)
                          {
                              if (key.ends_with("Texture") && value.is_map() && value.find("index") != nullptr)
                                  visit(*value.find("index"));
                          });
        };
        visit_textures([&](const Value& index) { gone.erase(index.as_int()); });
        Value::List& textures = list_of(document_, "textures");
        std::set<std::int64_t> gone_images;
        const auto visit_images = [](Value& texture, const auto& visit)
        {
            visit_entries(texture,
                          [&](const std::string& key, Value& value)
                          {
                              if (key == "source")
                                  visit(value);
                          });
        };
        for (const std::int64_t number : gone)
            visit_images(textures.at(static_cast<std::size_t>(number)),
                         [&](const Value& image) { gone_images.insert(image.as_int()); });
        const auto texture_numbers = removed(textures, gone);
        visit_textures([&](Value& index) { index = texture_numbers.at(static_cast<std::size_t>(index.as_int())); });
        for (Value& texture : textures)
            visit_images(texture, [&](const Value& image) { gone_images.erase(image.as_int()); });
        const auto image_numbers = removed(list_of(document_, "images"), gone_images);
        for (Value& texture : textures)
            visit_images(texture, [&](Value& image) { image = image_numbers.at(static_cast<std::size_t>(image.as_int())); });
    }

    /// Pictures beside the file, or as text in it, become parts of the GLB.
    void embed_images()
    {
        const fresco::gltf::ModelFolder folder(path_);
        Value::List& images = list_of(document_, "images");
        for (std::size_t i = 0; i < images.size(); ++i)
        {
            const Value* const uri = images[i].find("uri");
            if (uri == nullptr)
                continue;
            std::vector<std::byte> bytes;
            if (fresco::gltf::is_data_uri(uri->as_string()))
                bytes = fresco::gltf::data_uri_bytes(uri->as_string(), entry("images", i));
            else
            {
                result_.files_read.push_back(
                    folder.find(fresco::gltf::decoded_uri(uri->as_string()), entry("images", i) + "uri"));
                bytes = fresco::read_file(result_.files_read.back());
            }
            const std::string suffix(fresco::gltf::suffix_of(bytes));
            remove(images[i], "uri");
            const auto* const begin = reinterpret_cast<const unsigned char*>(bytes.data());
            images[i].set("bufferView", add_view({begin, begin + bytes.size()}));
            images[i].set("mimeType", suffix == ".jpg" ? "image/jpeg" : "image/" + (suffix.empty() ? "png" : suffix.substr(1)));
        }
    }

    // --- vertices

    void paint(const PaintedPrimitive& each)
    {
        Value& primitive = json_of(each);
        Value& attributes = *primitive.find("attributes");
        if (attributes.find("COLOR_0") != nullptr)
            release_color(attributes);
        int set = 0;
        if (!painting_.keeps_uvs)
        {
            while (attributes.find(fmt::format("TEXCOORD_{}", set)) != nullptr)
                ++set;
            add_texcoords(each, primitive, set);
        }
        primitive.set("material", painted_material(file_.model.meshes[each.mesh].primitives[each.primitive].material, set));
    }

    void release_color(Value& attributes)
    {
        --accessor_uses_[attributes.at("COLOR_0").as_int()];
        remove(attributes, "COLOR_0");
    }

    void add_texcoords(const PaintedPrimitive& each, Value& primitive, int set)
    {
        const tinygltf::Primitive& source = file_.model.meshes[each.mesh].primitives[each.primitive];
        const std::size_t vertices = accessor_rows(file_.model, source.attributes.at("POSITION"), 3, 3).count;
        const SplitVertices split = split_vertices(each.corners, each.texcoords, each.painted, vertices);
        const bool is_packed = extension_of(primitive, draco) != nullptr;
        const bool is_split = split.source.size() > vertices;
        result_.vertices_added += split.source.size() - vertices;
        if (is_split || is_packed)
        {
            std::map<std::int64_t, std::int64_t> moved;
            visit_accessors(primitive,
                            [&](Value& accessor)
                            {
                                const auto [found, is_new] = moved.try_emplace(accessor.as_int(), 0);
                                if (is_new)
                                    found->second = gathered(accessor.as_int(), split.source);
                                else
                                    --accessor_uses_[accessor.as_int()];
                                accessor = found->second;
                            });
            remove_extension(primitive, draco);
        }
        const bool has_list = source.indices >= 0 && source.mode == TINYGLTF_MODE_TRIANGLES;
        if (is_packed || (!has_list && (is_split || source.mode != TINYGLTF_MODE_TRIANGLES)) || (has_list && is_split))
            set_indices(primitive, split);
        std::vector<Vec2f> flipped = split.texcoords;
        for (Vec2f& uv : flipped)
            uv.y = 1 - uv.y;
        Value accessor = Value::Map{{"bufferView", add_view(bytes_of(flipped), array_buffer)},
                                    {"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT},
                                    {"count", flipped.size()},
                                    {"type", "VEC2"}};
        primitive.find("attributes")->set(fmt::format("TEXCOORD_{}", set), add_accessor(std::move(accessor)));
    }

    void set_indices(Value& primitive, const SplitVertices& split)
    {
        const bool is_large = split.source.size() > restart_index;
        const std::vector<std::uint16_t> small(split.corners.begin(), split.corners.end());
        Value accessor = Value::Map{
            {"bufferView", add_view(is_large ? bytes_of(split.corners) : bytes_of(small), element_array_buffer)},
            {"componentType", is_large ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
            {"count", split.corners.size()},
            {"type", "SCALAR"}};
        const std::int64_t old = index_or(primitive, "indices", -1);
        primitive.set("indices", old >= 0 && accessor_uses_[old] == 1 ? replace_accessor(old, std::move(accessor))
                                                                      : add_accessor(std::move(accessor)));
        --accessor_uses_[old];
        remove(primitive, "mode");
    }

    /// The rows of an accessor in another order, as they are. Takes the accessor's place where nothing else uses it.
    std::int64_t gathered(std::int64_t accessor, const std::vector<std::uint32_t>& source)
    {
        const AccessorRows rows = accessor_rows(file_.model, static_cast<int>(accessor), 1, 16);
        const std::size_t packed =
            rows.components *
            static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(rows.component_type)));
        const std::size_t stride = (packed + 3) / 4 * 4;
        std::vector<unsigned char> bytes(stride * source.size(), 0);
        for (std::size_t i = 0; i < source.size(); ++i)
            std::memcpy(&bytes[i * stride], rows.first + source[i] * rows.stride, packed);
        Value moved = list_of(document_, "accessors")[static_cast<std::size_t>(accessor)];
        remove(moved, "byteOffset");
        remove(moved, "sparse");
        moved.set("count", source.size());
        moved.set("bufferView", add_view(std::move(bytes), array_buffer, stride));
        const bool is_last = accessor_uses_[accessor]-- == 1;
        return is_last ? replace_accessor(accessor, std::move(moved)) : add_accessor(std::move(moved));
    }

    std::int64_t replace_accessor(std::int64_t number, Value accessor)
    {
        list_of(document_, "accessors")[static_cast<std::size_t>(number)] = std::move(accessor);
        return number;
    }

    std::int64_t add_accessor(Value accessor)
    {
        Value::List& accessors = list_of(document_, "accessors");
        accessors.push_back(std::move(accessor));
        return static_cast<std::int64_t>(accessors.size() - 1);
    }

    std::size_t add_view(std::vector<unsigned char> bytes, int target = 0, std::size_t stride = 0)
    {
        Value view = Value::Map{{"buffer", file_.model.buffers.size()}, {"byteLength", bytes.size()}};
        if (stride != 0)
            view.set("byteStride", stride);
        if (target != 0)
            view.set("target", target);
        file_.model.buffers.emplace_back().data = std::move(bytes);
        Value::List& views = list_of(document_, "bufferViews");
        views.push_back(std::move(view));
        return views.size() - 1;
    }

    // --- the file

    bool uses_draco()
    {
        bool uses = false;
        visit_entries(list_of(document_, "meshes"), [&](const std::string& key, Value&) { uses = uses || key == draco; });
        return uses;
    }

    void remove_unused_views()
    {
        Value::List& views = list_of(document_, "bufferViews");
        std::set<std::int64_t> gone;
        for (std::size_t i = 0; i < views.size(); ++i)
            gone.insert(static_cast<std::int64_t>(i));
        const auto visit_views = [&](const auto& visit)
        {
            visit_entries(document_,
                          [&](const std::string& key, Value& value)
                          {
                              if (key == "bufferView")
                                  visit(value);
                          });
        };
        visit_views([&](const Value& view) { gone.erase(view.as_int()); });
        const auto numbers = removed(views, gone);
        visit_views([&](Value& view) { view = numbers.at(static_cast<std::size_t>(view.as_int())); });
    }

    void add_origin()
    {
        if (painting_.origin.as_map().empty())
            return;
        Value& asset = *document_.find("asset");
        Value extras = asset.find("extras") != nullptr && asset.at("extras").is_map() ? asset.at("extras") : Value(Value::Map{});
        for (const auto& [key, value] : painting_.origin.as_map())
            extras.set(key, value);
        asset.set("extras", std::move(extras));
    }

    /// The bytes of views one after the other in one buffer. Compressed views keep their buffers without bytes.
    std::string packed()
    {
        std::string binary;
        std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::size_t> places;
        Value::List buffers{Value::Map{}};
        std::map<std::int64_t, std::size_t> empty_buffers;
        const auto move = [&](Value& view)
        {
            const std::int64_t buffer = view.at("buffer").as_int();
            const std::int64_t offset = index_or(view, "byteOffset", 0);
            const std::int64_t length = view.at("byteLength").as_int();
            const auto& bytes = file_.model.buffers.at(static_cast<std::size_t>(buffer)).data;
            if (bytes.empty())
            {
                const auto [found, is_new] = empty_buffers.try_emplace(buffer, buffers.size());
                if (is_new)
                    buffers.push_back(list_of(document_, "buffers").at(static_cast<std::size_t>(buffer)));
                view.set("buffer", found->second);
                return;
            }
            const auto [found, is_new] = places.try_emplace({buffer, offset, length}, binary.size());
            if (is_new)
            {
                binary.append(reinterpret_cast<const char*>(bytes.data()) + offset, static_cast<std::size_t>(length));
                binary.resize((binary.size() + 3) / 4 * 4);
            }
            view.set("buffer", 0);
            view.set("byteOffset", found->second);
        };
        for (Value& view : list_of(document_, "bufferViews"))
        {
            if (Value* const compressed = extension_of(view, meshopt))
                move(*compressed);
            move(view);
        }
        buffers[0] = Value::Map{{"byteLength", binary.size()}};
        document_.set("buffers", std::move(buffers));
        for (const char* const list : {"extensionsUsed", "extensionsRequired", "meshes", "materials"})
            if (const Value* const found = document_.find(list); found != nullptr && found->as_list().empty())
                remove(document_, list);
        return fresco::texturing::glb_of(document_, binary);
    }

    GltfFile file_;
    Value& document_;
    const fs::path& path_;
    const Painting& painting_;
    PaintedFiles& result_;
    std::vector<PaintedPrimitive> primitives_;
    std::set<std::pair<std::size_t, std::size_t>> painted_uses_;  ///< Mesh and primitive.
    std::size_t face_uses_ = 0;
    std::vector<bool> cutout_;
    bool has_cutout_ = false;
    std::map<std::int64_t, int> accessor_uses_;
    std::size_t texture_ = 0;
    std::map<std::pair<int, int>, std::size_t> painted_materials_;
    std::set<int> changed_materials_;
    Value::List originals_;  ///< The materials as the file has them.
    std::set<std::int64_t> old_textures_;
};

}  // namespace

void check_faces(const fs::path& file, std::size_t faces, const Painting& painting)
{
    if (faces != painting.atlas.triangles.size())
        throw Error(fmt::format(
            "{} has {} triangles, the painted mesh has {}: wire an atlas of the model as it is, without mesh.decimate, "
            "or set uvs: new",
            file.string(), faces, painting.atlas.triangles.size()));
}

PaintedFiles painted_gltf(const fs::path& file, const Painting& painting)
{
    PaintedFiles result;
    const fresco::gltf::ModelFolder folder(file);
    const auto read_beside = [&](const std::string& uri, const std::string& place)
    {
        result.files_read.push_back(folder.find(fresco::gltf::decoded_uri(uri), place + "uri"));
        return fresco::read_file(result.files_read.back());
    };
    GltfFile gltf = fresco::gltf::load_gltf(fresco::read_file(file), read_beside);
    std::string glb = GltfPainter(std::move(gltf), file, painting, result).glb();
    result.files.insert(result.files.begin(), {painting.name + ".glb", std::move(glb)});
    return result;
}

}  // namespace export_model
