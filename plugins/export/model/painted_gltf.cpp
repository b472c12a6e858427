#include "gltf_edit.h"
#include "painted_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/gltf/scene.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <string_view>

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
constexpr std::size_t most_copied_primitives = 1'000'000;
constexpr int element_array_buffer = 34963;
constexpr std::string_view draco = "KHR_draco_mesh_compression";
constexpr std::string_view instancing = "EXT_mesh_gpu_instancing";
constexpr std::string_view emissive_strength = "KHR_materials_emissive_strength";
constexpr std::string_view variants = "KHR_materials_variants";
constexpr std::string_view specular_glossiness = "KHR_materials_pbrSpecularGlossiness";

/// Extensions that name textures, images and views by the format's own keys, as those of KHR_materials_… do.
constexpr std::array<std::string_view, 9> plain_extensions{"EXT_meshopt_compression", draco,
                                                           "EXT_texture_webp",        "EXT_texture_avif",
                                                           "KHR_texture_basisu",      "KHR_texture_transform",
                                                           "KHR_mesh_quantization",   "KHR_lights_punctual",
                                                           "KHR_node_visibility"};

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

/// Whether scan.mesh took the emission for a material's color: it shines, and its color is black or, beside a picture that
/// shines, a plain white.
bool shows_emission(const Value& material)
{
    const auto all_are = [](const Value* factor, double value)
    {
        for (std::size_t i = 0; factor != nullptr && i < 3; ++i)
            if (factor->as_list().at(i).as_double() != value)
                return false;
        return factor != nullptr;
    };
    const Value* const strength = extension_of(material, emissive_strength);
    const Value* const times = strength == nullptr ? nullptr : strength->find("emissiveStrength");
    const Value* const factor = material.find("emissiveFactor");
    if (factor == nullptr || all_are(factor, 0) || (times != nullptr && times->as_double() == 0))
        return false;
    const Value* const older = extension_of(material, specular_glossiness);
    const Value* const colors = older != nullptr ? older : material.find("pbrMetallicRoughness");
    const std::string name = older != nullptr ? "diffuse" : "baseColor";
    const Value* const base = colors == nullptr ? nullptr : colors->find(name + "Factor");
    const bool is_plain =
        (colors == nullptr || colors->find(name + "Texture") == nullptr) && (base == nullptr || all_are(base, 1));
    return all_are(base, 0) || (is_plain && material.find("emissiveTexture") != nullptr);
}

/// The reference to the picture that scan.mesh took for a material's color, or null.
const Value* shown_texture(const Value& material)
{
    if (shows_emission(material))
        return material.find("emissiveTexture");
    if (const Value* const older = extension_of(material, specular_glossiness))
        return older->find("diffuseTexture");
    const Value* const pbr = material.find("pbrMetallicRoughness");
    return pbr == nullptr ? nullptr : pbr->find("baseColorTexture");
}

/// Empty for bytes that no picture of glTF begins with.
std::string_view mime_type(std::span<const std::byte> picture)
{
    const std::string_view text(reinterpret_cast<const char*>(picture.data()), picture.size());
    if (text.starts_with("\xABKTX 20"))
        return "image/ktx2";
    if (text.size() > 12 && text.substr(4, 8) == "ftypavif")
        return "image/avif";
    if (text.starts_with("\x89PNG"))
        return "image/png";
    if (text.starts_with("\xFF\xD8\xFF"))
        return "image/jpeg";
    return text.starts_with("RIFF") && text.substr(8).starts_with("WEBP") ? "image/webp" : "";
}

class GltfPainter : GltfEdit
{
  public:
    GltfPainter(GltfFile file, const fs::path& path, const Painting& painting, PaintedFiles& result)
        : GltfEdit(std::move(file)), path_(path), painting_(painting), result_(result),
          originals_(list_of(document_, "materials"))
    {
    }

    std::string glb()
    {
        find_painted();
        check_faces(path_, faces_, painting_);
        count_uses();
        add_picture();
        for (const PaintedPrimitive& each : primitives_)
            paint(each);
        if (!uses_extension("nodes", instancing))
            forget_extension(instancing);
        // Extensions that are not known may name textures, pictures and views by any key.
        const bool may_remove = knows_extensions();
        if (may_remove)
            remove_old_pictures();
        if (!uses_extension("meshes", draco))
            forget_extension(draco);
        embed_images();
        if (may_remove)
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

    const Value* original(int material) const
    {
        return material < 0 ? nullptr : &originals_.at(static_cast<std::size_t>(material));
    }

    const tinygltf::Primitive& source_of(const PaintedPrimitive& each) const
    {
        return file_.model.meshes[each.mesh].primitives[each.primitive];
    }

    std::size_t vertices_of(const tinygltf::Primitive& primitive) const
    {
        const auto found = primitive.attributes.find("POSITION");
        return accessor_rows(file_.model, found == primitive.attributes.end() ? -1 : found->second, 3, 3).count;
    }

    // --- faces

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
            if (mesh >= file_.model.meshes.size())
                throw Error(fmt::format("{}mesh {} of {}", entry("nodes", node), mesh, file_.model.meshes.size()));
            if (!painting_.keeps_uvs && !used.insert(mesh).second)
                mesh = copied_mesh(node, mesh);
            std::vector<std::pair<std::size_t, bool>> copies;  // Meshes, and whether they are mirrored.
            for (const auto& [number, copy] : unpacked_copies(node))
            {
                if (!painting_.keeps_uvs && !copies.empty())
                    mesh = copied_mesh(number, mesh);
                copies.emplace_back(mesh, determinant((place * copy).linear) < 0);
            }
            for (std::size_t i = 0; i < file_.model.meshes[mesh].primitives.size(); ++i)
                for (const auto& [copied, is_mirrored] : copies)
                    find_painted(copied, i, is_mirrored);
        }
    }

    /// Makes children of a node from its copies by EXT_mesh_gpu_instancing, which would share their texture coordinates. Returns
    /// the nodes with the copies, and their places in it; a node without copies is its own.
    std::vector<std::pair<std::size_t, fresco::gltf::Affine>> unpacked_copies(std::size_t node)
    {
        Value::List& nodes = list_of(document_, "nodes");
        const std::vector<fresco::gltf::Affine> places = fresco::gltf::copies_of(file_.model, file_.model.nodes[node]);
        std::vector<std::pair<std::size_t, fresco::gltf::Affine>> copies;
        // Copies that keep their texture coordinates share the picture.
        if (painting_.keeps_uvs || extension_of(nodes[node], instancing) == nullptr)
        {
            for (const fresco::gltf::Affine& place : places)
                copies.emplace_back(node, place);
            return copies;
        }
        for (const auto& [linear, origin] : places)
        {
            Value::List matrix;
            for (int column = 0; column < 3; ++column)
                matrix.insert(matrix.end(), {linear(0, column), linear(1, column), linear(2, column), 0.0});
            matrix.insert(matrix.end(), {origin.x, origin.y, origin.z, 1.0});
            copies.emplace_back(nodes.size(), fresco::gltf::Affine{linear, origin});
            Value copy = Value::Map{{"mesh", nodes[node].at("mesh")}, {"matrix", std::move(matrix)}};
            if (const Value* const weights = nodes[node].find("weights"))
                copy.set("weights", *weights);
            nodes.push_back(std::move(copy));
            list_of(nodes[node], "children").push_back(nodes.size() - 1);
        }
        for (const char* const moved : {"mesh", "weights"})
            remove(nodes[node], moved);
        remove_extension(nodes[node], instancing);
        return copies;
    }

    std::size_t copied_mesh(std::size_t node, std::size_t mesh)
    {
        copied_primitives_ += file_.model.meshes[mesh].primitives.size();
        if (copied_primitives_ > most_copied_primitives)
            throw Error(
                fmt::format("nodes share meshes of more than {} primitives in all; set uvs: new", most_copied_primitives));
        Value::List& meshes = list_of(document_, "meshes");
        meshes.push_back(Value(meshes[mesh]));
        const tinygltf::Mesh copy = file_.model.meshes[mesh];
        file_.model.meshes.push_back(copy);
        list_of(document_, "nodes")[node].set("mesh", meshes.size() - 1);
        return meshes.size() - 1;
    }

    void find_painted(std::size_t mesh, std::size_t number, bool mirrored)
    {
        PaintedPrimitive each{mesh, number, {}, {}, {}};
        const tinygltf::Primitive& primitive = source_of(each);
        each.corners = fresco::gltf::triangle_indices(file_.model, primitive.indices, primitive.mode, vertices_of(primitive));
        if (each.corners.empty())
            return;
        const bool is_cutout = is_cutout_material(primitive.material);
        each.texcoords.resize(each.corners.size());
        for (std::size_t i = 0; i < each.corners.size(); i += 3)
        {
            const std::uint32_t* const t = &each.corners[i];
            each.painted.push_back(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            if (!each.painted.back())
                continue;
            if (faces_ == painting_.atlas.triangles.size())
                check_faces(path_, faces_ + 1, painting_);
            // The reader turns the faces of mirrored nodes by swapping their last two corners.
            for (std::size_t k = 0; k < 3; ++k)
                each.texcoords[i + (mirrored && k > 0 ? 3 - k : k)] = painting_.atlas.texcoords[3 * faces_ + k];
            cutout_.push_back(is_cutout);
            ++faces_;
        }
        has_cutout_ = has_cutout_ || is_cutout;
        // A primitive without the texcoords that are kept keeps its color.
        if (painting_.keeps_uvs && !primitive.attributes.contains(fmt::format("TEXCOORD_{}", texcoord_set(primitive.material))))
            return;
        painted_uses_.emplace(mesh, number);
        primitives_.push_back(std::move(each));
    }

    bool is_cutout_material(int material) const
    {
        const Value* const mode = material < 0 ? nullptr : original(material)->find("alphaMode");
        return mode != nullptr && mode->as_string() != "OPAQUE";
    }

    std::size_t texcoord_set(int material) const
    {
        const Value* const info = material < 0 ? nullptr : shown_texture(*original(material));
        if (info == nullptr)
            return 0;
        const std::size_t set = size_or(*info, "texCoord", 0);
        const Value* const transform = extension_of(*info, "KHR_texture_transform");
        return transform == nullptr ? set : size_or(*transform, "texCoord", set);
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

    /// The materials that a primitive has in variants of the model.
    template <class Visit>
    static void visit_variants(Value& primitive, const Visit& visit)
    {
        if (Value* const extension = extension_of(primitive, variants))
            for (Value& mapping : list_of(*extension, "mappings"))
                if (Value* const material = mapping.find("material"))
                    visit(*material);
    }

    /// Counts the uses of accessors, and finds the materials of what is not painted.
    void count_uses()
    {
        for (Value& mesh : list_of(document_, "meshes"))
            for (Value& primitive : mesh.find("primitives")->as_list())
            {
                visit_accessors(primitive, [&](const Value& accessor) { ++accessor_uses_[accessor.as_int()]; });
                visit_variants(primitive,
                               [&](const Value& material) { unpainted_materials_.insert(static_cast<int>(material.as_int())); });
                if (const Value* const indices = primitive.find("indices"))
                    ++accessor_uses_[indices->as_int()];
            }
        for (const char* const list : {"animations", "skins"})
            visit_entries(list_of(document_, list),
                          [&](const std::string& key, const Value& value)
                          {
                              if (key == "input" || key == "output" || key == "inverseBindMatrices")
                                  ++accessor_uses_[value.as_int()];
                          });
        for (std::size_t mesh = 0; mesh < file_.model.meshes.size(); ++mesh)
            for (std::size_t i = 0; i < file_.model.meshes[mesh].primitives.size(); ++i)
                if (!painted_uses_.contains({mesh, i}))
                    unpainted_materials_.insert(file_.model.meshes[mesh].primitives[i].material);
    }

    // --- pictures and materials

    void add_picture()
    {
        const Picture picture = painting_.picture(has_cutout_ ? cutout_ : std::vector<bool>{});
        Value::List& images = list_of(document_, "images");
        images.push_back(Value::Map{{"bufferView", add_view(picture.bytes)},
                                    {"mimeType", picture.extension == ".jpg" ? "image/jpeg" : "image/png"}});
        constexpr int linear = 9729;
        constexpr int linear_mipmap_linear = 9987;
        constexpr int clamp_to_edge = 33071;
        Value::List& samplers = list_of(document_, "samplers");
        samplers.push_back(Value::Map{
            {"magFilter", linear}, {"minFilter", linear_mipmap_linear}, {"wrapS", clamp_to_edge}, {"wrapT", clamp_to_edge}});
        Value::List& textures = list_of(document_, "textures");
        textures.push_back(Value::Map{{"sampler", samplers.size() - 1}, {"source", images.size() - 1}});
        texture_ = textures.size() - 1;
    }

    /// The number of the painted form of a material that finds the picture by the texcoords `set`. Materials that something else
    /// uses, too, are copied.
    std::size_t painted_material(int material, std::size_t set)
    {
        const auto [found, is_new] = painted_materials_.try_emplace({material, set}, 0);
        if (!is_new)
            return found->second;
        Value::List& materials = list_of(document_, "materials");
        const bool is_copied =
            material < 0 || unpainted_materials_.contains(material) || !changed_materials_.insert(material).second;
        found->second = is_copied ? materials.size() : static_cast<std::size_t>(material);
        if (is_copied)
            materials.push_back(material < 0 ? Value(Value::Map{}) : *original(material));
        paint_material(materials[found->second], set);
        return found->second;
    }

    void paint_material(Value& material, std::size_t set)
    {
        if (shows_emission(material))
        {
            paint_color(material, "emissiveTexture", "emissiveFactor", set);
            remove_extension(material, emissive_strength);
            return;
        }
        Value* const older = extension_of(material, specular_glossiness);
        if (older != nullptr)
            paint_color(*older, "diffuseTexture", "diffuseFactor", set);
        else if (material.find("pbrMetallicRoughness") == nullptr)
            material.set("pbrMetallicRoughness", Value::Map{});
        if (Value* const pbr = material.find("pbrMetallicRoughness"))
            paint_color(*pbr, "baseColorTexture", "baseColorFactor", set);
    }

    /// A factor keeps its alpha: its color went into the painting.
    void paint_color(Value& map, const char* texture_key, const char* factor_key, std::size_t set)
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

    /// Whether pictures and views can be renumbered.
    bool knows_extensions()
    {
        for (const Value& each : list_of(document_, "extensionsUsed"))
        {
            const std::string& name = each.as_string();
            if (name == "KHR_animation_pointer")
                result_.messages.push_back(name +
                                           ": what it animates in a material or a shared mesh may have another number now");
            else if (!name.starts_with("KHR_materials_") && std::ranges::find(plain_extensions, name) == plain_extensions.end())
                return false;
        }
        return true;
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
        const auto visit_images = [](Value& texture, const auto& visit)
        {
            visit_entries(texture,
                          [&](const std::string& key, Value& value)
                          {
                              if (key == "source")
                                  visit(value);
                          });
        };
        visit_textures([&](const Value& index) { gone.erase(index.as_int()); });
        Value::List& textures = list_of(document_, "textures");
        std::set<std::int64_t> gone_images;
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

    /// Pictures beside the file, or as text in it, become parts of the GLB, each file once.
    void embed_images()
    {
        const fresco::recordings::ModelFolder folder(path_, result_);
        std::map<fs::path, std::size_t> views;
        Value::List& images = list_of(document_, "images");
        for (std::size_t i = 0; i < images.size(); ++i)
        {
            const Value* const found = images[i].find("uri");
            if (found == nullptr)
                continue;
            const std::string uri = found->as_string();
            remove(images[i], "uri");
            std::size_t view = 0;
            if (fresco::gltf::is_data_uri(uri))
                view = add_view(fresco::gltf::data_uri_bytes(uri, entry("images", i)));
            else
            {
                const fs::path file = folder.find(fresco::gltf::decoded_uri(uri), entry("images", i) + "uri");
                const auto [known, is_new] = views.try_emplace(fs::canonical(file), 0);
                if (is_new)
                {
                    result_.files_read.push_back(file);
                    known->second = add_view(fresco::read_file(file));
                }
                view = known->second;
            }
            const auto& bytes = file_.model.buffers.at(size_or(list_of(document_, "bufferViews")[view], "buffer", 0)).data;
            const std::string_view type = mime_type(std::as_bytes(std::span(bytes)));
            images[i].set("bufferView", view);
            if (!type.empty())
                images[i].set("mimeType", type);
            else if (images[i].find("mimeType") == nullptr)
                throw Error(entry("images", i) + "not PNG, JPEG, WebP, AVIF or KTX2; export the model with PNG or JPEG pictures");
        }
    }

    // --- vertices

    void paint(const PaintedPrimitive& each)
    {
        Value& primitive = list_of(document_, "meshes")[each.mesh].find("primitives")->as_list()[each.primitive];
        const int material = source_of(each).material;
        const Value* const own = original(material);
        if (primitive.at("attributes").find("COLOR_0") != nullptr && (own == nullptr || !shows_emission(*own)))
            release_color(primitive, is_cutout_material(material));
        std::size_t set = 0;
        if (!painting_.keeps_uvs)
        {
            while (primitive.at("attributes").find(fmt::format("TEXCOORD_{}", set)) != nullptr)
                ++set;
            add_texcoords(each, primitive, set);
        }
        const std::size_t painted = painted_material(material, set);
        primitive.set("material", painted);
        visit_variants(primitive,
                       [&](Value& other)
                       {
                           if (other.as_int() == material)
                               other = painted;
                       });
    }

    /// Takes a primitive's colors out; where their alpha counts, they become white.
    void release_color(Value& primitive, bool is_cutout)
    {
        Value& attributes = *primitive.find("attributes");
        const std::int64_t old = attributes.at("COLOR_0").as_int();
        const AccessorRows rows = accessor_rows(file_.model, static_cast<int>(old), 3, 4);
        --accessor_uses_[old];
        if (Value* const form = extension_of(primitive, draco))
            remove(*form->find("attributes"), "COLOR_0");
        if (is_cutout && rows.components == 4)
        {
            std::vector<float> white;
            for (std::size_t i = 0; i < rows.count; ++i)
                white.insert(white.end(), {1, 1, 1, static_cast<float>(rows.at(i, 3))});
            const std::int64_t number = add_floats(white, rows.count, "VEC4");
            accessor_uses_[number] = 1;
            attributes.set("COLOR_0", number);
            return;
        }
        remove(attributes, "COLOR_0");
        if (Value* const targets = primitive.find("targets"))
            for (Value& target : targets->as_list())
                remove(target, "COLOR_0");
    }

    void add_texcoords(const PaintedPrimitive& each, Value& primitive, std::size_t set)
    {
        const tinygltf::Primitive& source = source_of(each);
        const std::size_t vertices = vertices_of(source);
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
                                    found->second = gathered(accessor.as_int(), vertices, split.source);
                                accessor = found->second;
                            });
            remove_extension(primitive, draco);
        }
        if (is_packed || is_split || source.mode != TINYGLTF_MODE_TRIANGLES)
            set_indices(primitive, split);
        std::vector<float> flipped;
        for (const Vec2f uv : split.texcoords)
            flipped.insert(flipped.end(), {uv.x, 1 - uv.y});
        primitive.find("attributes")->set(fmt::format("TEXCOORD_{}", set), add_floats(flipped, split.texcoords.size(), "VEC2"));
    }

    void set_indices(Value& primitive, const SplitVertices& split)
    {
        const bool is_large = split.source.size() > restart_index;
        std::vector<std::uint16_t> small;
        if (!is_large)
            small.assign(split.corners.begin(), split.corners.end());
        const auto bytes = is_large ? std::as_bytes(std::span(split.corners)) : std::as_bytes(std::span(small));
        Value accessor = Value::Map{
            {"bufferView", add_view(bytes, element_array_buffer)},
            {"componentType", is_large ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT},
            {"count", split.corners.size()},
            {"type", "SCALAR"}};
        const Value* const old = primitive.find("indices");
        primitive.set("indices", set_accessor(old == nullptr ? -1 : old->as_int(), std::move(accessor)));
        remove(primitive, "mode");
    }

    // --- the file

    bool uses_extension(const char* list, std::string_view name)
    {
        bool uses = false;
        visit_entries(list_of(document_, list), [&](const std::string& key, Value&) { uses = uses || key == name; });
        return uses;
    }

    void forget_extension(std::string_view name)
    {
        for (const char* const list : {"extensionsUsed", "extensionsRequired"})
            std::erase(list_of(document_, list), Value(name));
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

    const fs::path& path_;
    const Painting& painting_;
    PaintedFiles& result_;
    Value::List originals_;  ///< The materials as the file has them.
    std::vector<PaintedPrimitive> primitives_;
    std::set<std::pair<std::size_t, std::size_t>> painted_uses_;  ///< Mesh and primitive.
    std::set<int> unpainted_materials_;
    std::size_t faces_ = 0;
    std::size_t copied_primitives_ = 0;
    std::vector<bool> cutout_;
    bool has_cutout_ = false;
    std::size_t texture_ = 0;
    std::map<std::pair<int, std::size_t>, std::size_t> painted_materials_;
    std::set<int> changed_materials_;
    std::set<std::int64_t> old_textures_;
};

}  // namespace

void check_faces(const fs::path& file, std::size_t faces, const Painting& painting)
{
    if (faces != painting.atlas.triangles.size())
        throw Error(
            fmt::format("{}: the file has {} triangles or more, the painted mesh has {}: wire an atlas of the model as it is, "
                        "without mesh.decimate, or set uvs: new",
                        file.string(), faces, painting.atlas.triangles.size()));
}

PaintedFiles painted_gltf(const fs::path& file, const Painting& painting)
{
    PaintedFiles result;
    const fresco::recordings::ModelFolder folder(file, result);
    std::set<fs::path> buffers;
    const auto read_beside = [&](const std::string& uri, const std::string& place)
    {
        result.files_read.push_back(folder.find(fresco::gltf::decoded_uri(uri), place + "uri"));
        if (!buffers.insert(fs::canonical(result.files_read.back())).second)
            throw Error(place + "uri: another buffer has the same file; export the model again");
        return fresco::read_file(result.files_read.back());
    };
    try
    {
        GltfFile gltf = fresco::gltf::load_gltf(fresco::read_file(file), read_beside);
        std::string glb = GltfPainter(std::move(gltf), file, painting, result).glb();
        result.files.insert(result.files.begin(), {painting.name + ".glb", std::move(glb)});
    }
    catch (const fresco::MissingInput&)
    {
        throw;
    }
    catch (const Error& error)
    {
        const std::string what = error.what();
        throw Error(what.starts_with(file.string()) ? what : file.string() + ": " + what);
    }
    catch (const std::out_of_range&)
    {
        throw Error(file.string() + ": an index names an entry that is not there; export the model again");
    }
    return result;
}

}  // namespace export_model
