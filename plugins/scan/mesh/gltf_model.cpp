#include "file_model.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/gltf/gltf_file.h>
#include <fresco/gltf/scene.h>
#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/texturing/texture_pictures.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

namespace scan_mesh
{
namespace
{

namespace fs = std::filesystem;
using fresco::Error;
using fresco::Vec3d;
using fresco::gltf::accessor_rows;
using fresco::gltf::AccessorRows;
using fresco::gltf::Affine;
using fresco::gltf::entry;
using fresco::gltf::GltfFile;

/// A material of a glTF file and how it places its picture.
struct GltfLook
{
    fresco::ModelMaterial material;
    int image = -1;  ///< -1: none.
    int texcoord_set = 0;
    std::array<double, 6> picture_from_uv{1, 0, 0, 0, 1, 0};  ///< Rows of a 2 x 3 matrix (KHR_texture_transform).
    bool is_emission = false;                                 ///< Vertex colors do not count.
};

/// An element of one of the file's lists. Throws Error that begins with `what`.
template <class List>
const auto& element(const List& list, int index, const std::string& what)
{
    if (index < 0 || static_cast<std::size_t>(index) >= list.size())
        throw Error(fmt::format("{} {} of {}", what, index, list.size()));
    return list[static_cast<std::size_t>(index)];
}

/// The numbers of an extension's entry; `otherwise` without one.
template <std::size_t N>
std::array<double, N> numbers_or(const tinygltf::Value& extension, const std::string& key, std::array<double, N> otherwise,
                                 const std::string& place)
{
    if (!extension.Has(key))
        return otherwise;
    const auto& list = extension.Get(key);
    if (!list.IsArray() || list.ArrayLen() < N)
        throw Error(fmt::format("{}{}: expected {} numbers", place, key, N));
    std::array<double, N> result;
    for (std::size_t i = 0; i < N; ++i)
    {
        result[i] = list.Get(static_cast<int>(i)).IsNumber() ? list.Get(static_cast<int>(i)).GetNumberAsDouble() : NAN;
        if (!std::isfinite(result[i]))
            throw Error(place + key + ": expected finite numbers");
    }
    return result;
}

int integer_or(const tinygltf::Value& map, const std::string& key, int otherwise)
{
    return map.Has(key) && map.Get(key).IsInt() ? map.Get(key).GetNumberAsInt() : otherwise;
}

fresco::Vec3f color_of(const double* factor)
{
    const auto light = [](double v) { return std::isfinite(v) ? static_cast<float>(std::clamp(v, 0.0, 1.0)) : 1.0F; };
    return {light(factor[0]), light(factor[1]), light(factor[2])};
}

fresco::Wrap wrap_of(int mode, const std::string& place)
{
    switch (mode)
    {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
        return fresco::Wrap::repeat;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return fresco::Wrap::mirror;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return fresco::Wrap::clamp;
    default:
        throw Error(fmt::format("{}wrap mode {}; expected 10497, 33071 or 33648", place, mode));
    }
}

/// uv' = T R S uv, as the extension's text has it.
std::array<double, 6> transform_of(const tinygltf::Value& extension, const std::string& place)
{
    const auto offset = numbers_or<2>(extension, "offset", {0, 0}, place);
    const auto scale = numbers_or<2>(extension, "scale", {1, 1}, place);
    const double angle = extension.Has("rotation") ? extension.Get("rotation").GetNumberAsDouble() : 0;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    if (!std::isfinite(c))
        throw Error(place + "rotation: expected a finite number");
    return {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
}

/// A reference to a texture, from the core material or from an extension.
struct TextureUse
{
    int texture = -1;
    int texcoord_set = 0;
    const tinygltf::Value* transform = nullptr;
};

const tinygltf::Value* find(const tinygltf::ExtensionMap& extensions, const char* name)
{
    const auto found = extensions.find(name);
    return found == extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
}

void take_texture(const GltfFile& gltf, const TextureUse& use, const std::string& place, GltfLook& look)
{
    const auto& texture = element(gltf.model.textures, use.texture, place + "texture");
    const std::string texture_place = entry("textures", static_cast<std::size_t>(use.texture));
    int source = texture.source;
    for (const char* const extension : {"EXT_texture_webp", "EXT_texture_avif"})
        if (const auto* const newer = find(texture.extensions, extension); source < 0 && newer != nullptr)
            source = integer_or(*newer, "source", -1);
    if (source < 0 || static_cast<std::size_t>(source) >= gltf.images.size())
        throw Error(fmt::format("{}image {} of {}; export the model with PNG or JPEG pictures", texture_place, source,
                                gltf.images.size()));
    look.image = source;
    look.texcoord_set = use.texcoord_set;
    if (texture.sampler >= 0)
    {
        const auto& sampler = element(gltf.model.samplers, texture.sampler, texture_place + "sampler");
        look.material.wrap_u = wrap_of(sampler.wrapS, texture_place);
        look.material.wrap_v = wrap_of(sampler.wrapT, texture_place);
    }
    if (use.transform != nullptr)
    {
        look.picture_from_uv = transform_of(*use.transform, place + "KHR_texture_transform: ");
        look.texcoord_set = integer_or(*use.transform, "texCoord", look.texcoord_set);
    }
}

/// The older form of a material, which Sketchfab and others export.
void take_specular_glossiness(const GltfFile& gltf, const tinygltf::Value& extension, const std::string& place,
                              bool with_pictures, GltfLook& look)
{
    look.material.color = color_of(numbers_or<3>(extension, "diffuseFactor", {1, 1, 1}, place).data());
    if (!with_pictures || !extension.Has("diffuseTexture"))
        return;
    const auto& info = extension.Get("diffuseTexture");
    TextureUse use{integer_or(info, "index", -1), integer_or(info, "texCoord", 0), nullptr};
    if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform"))
        use.transform = &info.Get("extensions").Get("KHR_texture_transform");
    take_texture(gltf, use, place, look);
}

/// Some models keep all colors in the emission, such as rooms with baked light: take it in place of a black color, and its
/// picture in place of a plain white.
void take_emission(const GltfFile& gltf, const tinygltf::Material& source, const std::string& place, GltfLook& look)
{
    double strength = 1;
    if (const auto* const extension = find(source.extensions, "KHR_materials_emissive_strength"))
        if (const auto& value = extension->Get("emissiveStrength"); value.IsNumber())
            strength = value.GetNumberAsDouble();
    std::array<double, 3> light{};
    std::ranges::transform(source.emissiveFactor, light.begin(), [&](double factor) { return factor * strength; });
    const fresco::Vec3f black{0, 0, 0};
    const fresco::Vec3f emission = color_of(light.data());
    const bool has_picture = source.emissiveTexture.index != -1;
    const bool is_plain = look.image == -1 && look.material.color == fresco::Vec3f{1, 1, 1};
    if (emission == black || !(look.material.color == black || (is_plain && has_picture)))
        return;
    look.is_emission = true;
    look.material.color = emission;
    look.image = -1;
    if (has_picture)
        take_texture(gltf,
                     {source.emissiveTexture.index, source.emissiveTexture.texCoord,
                      find(source.emissiveTexture.extensions, "KHR_texture_transform")},
                     place, look);
}

/// The color and, if wanted, picture of a material; white for -1. Throws Error naming the material or texture for invalid numbers
/// and indices.
GltfLook look_of(const GltfFile& gltf, int material, bool with_pictures)
{
    GltfLook look;
    if (material == -1)
        return look;
    const auto& source = element(gltf.model.materials, material, "material");
    const std::string place = entry("materials", static_cast<std::size_t>(material));
    look.material.name = source.name;
    if (const auto* const older = find(source.extensions, "KHR_materials_pbrSpecularGlossiness"))
    {
        take_specular_glossiness(gltf, *older, place, with_pictures, look);
    }
    else
    {
        const auto& pbr = source.pbrMetallicRoughness;
        look.material.color = color_of(pbr.baseColorFactor.data());
        if (with_pictures && pbr.baseColorTexture.index != -1)
            take_texture(gltf,
                         {pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord,
                          find(pbr.baseColorTexture.extensions, "KHR_texture_transform")},
                         place, look);
    }
    if (with_pictures)
        take_emission(gltf, source, place, look);
    return look;
}

/// Adds pictures to a model, each once, since overlapping ones could take any amount of memory.
class GltfPictures
{
  public:
    GltfPictures(const GltfFile& gltf, const fs::path& file, FileModel& model)
        : gltf_(gltf), file_(file), folder_(file, model), model_(model)
    {
    }

    /// The index in FileModel::pictures. Throws MissingInput, Error.
    int number_of(int image)
    {
        const auto found = numbers_.find(image);
        return found != numbers_.end() ? found->second
                                       : numbers_.emplace(image, added(static_cast<std::size_t>(image))).first->second;
    }

  private:
    int next() const { return static_cast<int>(model_.pictures.size()); }

    int added(std::size_t image)
    {
        const fresco::gltf::GltfImage& source = gltf_.images[image];
        const std::string place = entry("images", image);
        const std::string name = fmt::format("{}: image {}", file_.string(), image);
        if (source.buffer_view >= 0)
            return added_view(static_cast<std::size_t>(source.buffer_view), name, place);
        if (fresco::gltf::is_data_uri(source.uri))
            return added({name, {}, fresco::gltf::data_uri_bytes(source.uri, place)}, place);
        const auto file = folder_.find(fresco::gltf::decoded_uri(source.uri), place + "uri", shape_only);
        const auto [same, is_new] = of_files_.try_emplace(fs::canonical(file), next());
        if (is_new)
        {
            model_.pictures.push_back({file.string(), file, {}});
            model_.files_read.push_back(file);
        }
        return same->second;
    }

    int added_view(std::size_t view, const std::string& name, const std::string& place)
    {
        if (view >= gltf_.model.bufferViews.size())
            throw Error(fmt::format("{}bufferView {} of {}", place, view, gltf_.model.bufferViews.size()));
        const auto bytes = std::as_bytes(fresco::gltf::view_bytes(gltf_.model, view));
        const auto [same, is_new] = of_bytes_.try_emplace({bytes.data(), bytes.size()}, next());
        if (!is_new)
            return same->second;
        taken_bytes_ += bytes.size();
        std::size_t all = 0;
        for (const auto& buffer : gltf_.model.buffers)
            all += buffer.data.size();
        if (taken_bytes_ > all)
            throw Error(fmt::format("{}bufferView {}: the pictures overlap; export the model again", place, view));
        return added({name, {}, {bytes.begin(), bytes.end()}}, place);
    }

    int added(FilePicture picture, const std::string& place)
    {
        if (suffix_of(picture.bytes).empty())
            throw Error(place + "not PNG, JPEG, WebP or AVIF; export the model with PNG or JPEG pictures");
        model_.pictures.push_back(std::move(picture));
        return next() - 1;
    }

    const GltfFile& gltf_;
    const fs::path& file_;
    fresco::recordings::ModelFolder folder_;
    FileModel& model_;
    std::map<int, int> numbers_;  ///< Numbers of images.
    std::map<std::pair<const std::byte*, std::size_t>, int> of_bytes_;
    std::map<fs::path, int> of_files_;
    std::size_t taken_bytes_ = 0;  ///< From buffers.
};

class SceneReader
{
  public:
    SceneReader(const GltfFile& gltf, const fs::path& file, bool with_materials, FileModel& model)
        : gltf_(gltf), with_materials_(with_materials), model_(model), pictures_(gltf, file, model)
    {
    }

    void read()
    {
        std::map<int, std::string> paths;
        for (const auto& [number, place] : fresco::gltf::placed_nodes(gltf_.model))
        {
            const tinygltf::Node& node = gltf_.model.nodes[number];
            const std::string outer = paths[static_cast<int>(number)];
            const auto mesh = static_cast<std::size_t>(node.mesh);  // -1 without one.
            const bool is_unnamed = node.name.empty() && mesh < gltf_.model.meshes.size();
            const std::string path = ObjectNumbers::path(outer, is_unnamed ? gltf_.model.meshes[mesh].name : node.name);
            for (const int child : node.children)
                paths[child] = path;
            if (node.mesh < 0)
                continue;
            object_ = objects_.number_of(path);
            add_mesh(number, place);
        }
        model_.objects = objects_.paths();
        if (model_.mesh.triangles.empty())
            throw Error("the scene has no triangles" +
                        std::string(skipped_ > 0 ? ", only points and lines; export it as a triangle mesh" : ""));
        warn();
        if (!has_colors_)
            model_.mesh.colors.clear();
        if (!has_texcoords_)
            model_.mesh.texcoords.clear();
    }

  private:
    void add_mesh(std::size_t node, const Affine& place)
    {
        const auto mesh = static_cast<std::size_t>(gltf_.model.nodes[node].mesh);
        const auto& primitives =
            element(gltf_.model.meshes, gltf_.model.nodes[node].mesh, entry("nodes", node) + "mesh").primitives;
        is_posed_ = is_posed_ || gltf_.model.nodes[node].skin >= 0;
        std::vector<Affine> places;
        try
        {
            for (const Affine& copy : fresco::gltf::copies_of(gltf_.model, gltf_.model.nodes[node]))
                places.push_back(place * copy);
        }
        catch (const Error& error)
        {
            throw Error(entry("nodes", node) + "EXT_mesh_gpu_instancing: " + error.what());
        }
        for (std::size_t i = 0; i < primitives.size(); ++i)
            try
            {
                add_primitive(primitives[i], places);
            }
            catch (const fresco::MissingInput&)
            {
                throw;
            }
            catch (const Error& error)
            {
                throw Error(entry("meshes", mesh) + entry("primitives", i) + error.what());
            }
    }

    void add_primitive(const tinygltf::Primitive& primitive, const std::vector<Affine>& places)
    {
        const auto attribute = [&](const std::string& name)
        {
            const auto found = primitive.attributes.find(name);
            return found == primitive.attributes.end() ? -1 : found->second;
        };
        is_posed_ = is_posed_ || !primitive.targets.empty();
        if (primitive.mode != TINYGLTF_MODE_TRIANGLES && primitive.mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
            primitive.mode != TINYGLTF_MODE_TRIANGLE_FAN)
        {
            ++skipped_;
            return;
        }
        const AccessorRows positions = accessor_rows(gltf_.model, attribute("POSITION"), 3, 3);
        const auto corners = fresco::gltf::triangle_indices(gltf_.model, primitive.indices, primitive.mode, positions.count);
        if (corners.empty())
        {
            ++skipped_;
            return;
        }
        const fresco::MeshLimits limits;
        if (positions.count > (limits.max_vertices - model_.mesh.positions.size()) / places.size() ||
            corners.size() / 3 > (limits.max_faces - model_.mesh.triangles.size()) / places.size())
            throw Error(fmt::format("more than {} vertices or {} triangles, the limit", limits.max_vertices, limits.max_faces));
        const bool colored = attribute("COLOR_0") != -1;
        const AccessorRows colors = colored ? accessor_rows(gltf_.model, attribute("COLOR_0"), 3, 4) : AccessorRows{};
        const GltfLook& look =
            looks_.try_emplace(primitive.material, look_of(gltf_, primitive.material, with_materials_)).first->second;
        const int texcoords = attribute(fmt::format("TEXCOORD_{}", look.texcoord_set));
        const std::uint32_t material = material_number(primitive.material, look, texcoords != -1, colored);
        const AccessorRows uv = texcoords != -1 ? accessor_rows(gltf_.model, texcoords, 2, 2) : AccessorRows{};
        if (texcoords != -1 && uv.count != positions.count)
            throw Error(fmt::format("texture coordinates of {} vertices; expected {}", uv.count, positions.count));
        has_texcoords_ = has_texcoords_ || texcoords != -1;
        for (const Affine& place : places)
        {
            const auto first = static_cast<std::uint32_t>(model_.mesh.positions.size());
            add_positions(positions, place);
            add_colors(colors, positions.count);
            const bool mirrored = fresco::determinant(place.linear) < 0;
            for (std::size_t i = 0; i < corners.size(); i += 3)
            {
                std::array<std::uint32_t, 3> t{corners[i], corners[i + 1], corners[i + 2]};
                if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
                {
                    ++model_.report.degenerate_dropped;
                    continue;
                }
                if (mirrored)
                    std::swap(t[1], t[2]);
                model_.mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
                model_.material_of_face.push_back(material);
                model_.object_of_face.push_back(object_);
                for (const std::uint32_t vertex : t)
                    model_.mesh.texcoords.push_back(texcoords == -1 ? fresco::Vec2f{} : texcoord(uv, vertex, look));
            }
        }
    }

    void add_positions(const AccessorRows& rows, const Affine& place)
    {
        for (std::size_t i = 0; i < rows.count; ++i)
        {
            const Vec3d p = place.linear * Vec3d{rows.at(i, 0), rows.at(i, 1), rows.at(i, 2)} + place.origin;
            model_.report.positions.push_back(p);
            model_.mesh.positions.push_back(fresco::vec_cast<float>(p));
            const auto& stored = model_.mesh.positions.back();
            if (!std::isfinite(stored.x) || !std::isfinite(stored.y) || !std::isfinite(stored.z))
                throw Error(fmt::format("the position of vertex {} is not finite", i));
        }
    }

    /// COLOR_0 is linear light; vertices without are white.
    void add_colors(const AccessorRows& rows, std::size_t count)
    {
        if (rows.first != nullptr && rows.count != count)
            throw Error(fmt::format("colors of {} vertices; expected {}", rows.count, count));
        has_colors_ = has_colors_ || rows.first != nullptr;
        for (std::size_t i = 0; i < count; ++i)
        {
            fresco::Rgb8 color{255, 255, 255};
            for (std::size_t c = 0; c < 3 && rows.first != nullptr; ++c)
            {
                const double light = rows.at(i, c);
                if (!std::isfinite(light))
                    throw Error(fmt::format("the color of vertex {} is not finite", i));
                color[c] = fresco::texturing::from_linear(light);
            }
            model_.mesh.colors.push_back(color);
        }
    }

    /// glTF's origin is the upper left.
    static fresco::Vec2f texcoord(const AccessorRows& rows, std::size_t vertex, const GltfLook& look)
    {
        const double u = rows.at(vertex, 0);
        const double v = rows.at(vertex, 1);
        const auto& m = look.picture_from_uv;
        const fresco::Vec2f result{static_cast<float>(m[0] * u + m[1] * v + m[2]),
                                   static_cast<float>(1 - (m[3] * u + m[4] * v + m[5]))};
        if (!std::isfinite(result.x) || !std::isfinite(result.y))
            throw Error(fmt::format("the texture coordinate of vertex {} is not finite", vertex));
        return result;
    }

    std::uint32_t material_number(int number, const GltfLook& look, bool has_texcoords, bool has_colors)
    {
        const bool has_picture = look.image != -1 && has_texcoords;
        without_texcoords_ = without_texcoords_ || (look.image != -1 && !has_texcoords);
        const auto [found, is_new] =
            materials_.try_emplace({number, has_picture, has_colors}, static_cast<std::uint32_t>(model_.materials.size()));
        if (is_new)
        {
            fresco::ModelMaterial material = look.material;
            material.vertex_colors = has_colors && !look.is_emission;
            if (has_picture)
                material.picture = pictures_.number_of(look.image);
            model_.materials.push_back(std::move(material));
        }
        return found->second;
    }

    void warn()
    {
        const auto& used = gltf_.model.extensionsUsed;
        if (std::ranges::find(used, "KHR_materials_variants") != used.end())
            model_.warnings.emplace_back(
                "it has variants of its materials (KHR_materials_variants): the one shown at first is read");
        if (std::ranges::find(used, "KHR_node_visibility") != used.end())
            model_.warnings.emplace_back("nodes that it hides (KHR_node_visibility) are read, too");
        if (is_posed_)
            model_.warnings.emplace_back("skins and morph targets are not applied: the shape is the one without them");
        if (skipped_ > 0)
            model_.warnings.push_back(fmt::format("{} primitives of points or lines are left out", skipped_));
        if (without_texcoords_)
            model_.warnings.emplace_back("some meshes have a picture but no texture coordinates: they take the material's color");
    }

    const GltfFile& gltf_;
    bool with_materials_;
    FileModel& model_;
    GltfPictures pictures_;
    std::map<int, GltfLook> looks_;
    std::map<std::tuple<int, bool, bool>, std::uint32_t> materials_;
    ObjectNumbers objects_;
    std::uint32_t object_ = 0;  ///< The number of the node's.
    std::size_t skipped_ = 0;
    bool has_colors_ = false;
    bool has_texcoords_ = false;
    bool is_posed_ = false;
    bool without_texcoords_ = false;
};

}  // namespace

FileModel read_gltf_model(const fs::path& file, bool with_materials)
{
    FileModel model;
    model.split_vertices = true;
    model.is_gltf = true;
    try
    {
        std::set<fs::path> buffers;
        const auto read_beside = [&](const std::string& uri, const std::string& place)
        {
            model.files_read.push_back(
                fresco::recordings::ModelFolder(file, model).find(fresco::gltf::decoded_uri(uri), place + "uri"));
            if (!buffers.insert(fs::canonical(model.files_read.back())).second)
                throw Error(place + "uri: another buffer has the same file; export the model again");
            return fresco::read_file(model.files_read.back());
        };
        const GltfFile gltf = fresco::gltf::load_gltf(fresco::read_file(file), read_beside);
        SceneReader(gltf, file, with_materials, model).read();
    }
    catch (const fresco::MissingInput& error)
    {
        const std::string what = error.what();
        throw fresco::MissingInput(what.starts_with(file.string()) ? what : file.string() + ": " + what);
    }
    catch (const Error& error)
    {
        throw Error(file.string() + ": " + error.what());
    }
    return model;
}

std::vector<fresco::FileFormat> model_formats()
{
    // PDAL reads these, with .laz among them.
    const std::string points =
        "a point cloud without faces: pdal translate FILE mesh.ply normal poisson --writers.ply.faces=true makes a mesh of it";
    return {fresco::ply_format(),
            fresco::obj_format(),
            fresco::gltf::glb_format(),
            fresco::gltf::gltf_format(),
            {.name = points, .begins = {"ASTM-E57", "LASF"}}};
}

}  // namespace scan_mesh
