#include "gltf_materials.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <string_view>

namespace scan_mesh
{

using fresco::Error;
using fresco::gltf::entry;
using fresco::gltf::GltfFile;

namespace
{

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

void take_texture(const GltfFile& gltf, const TextureUse& use, const std::string& place, GltfLook& look)
{
    const auto& model = gltf.model;
    if (use.texture < 0 || static_cast<std::size_t>(use.texture) >= model.textures.size())
        throw Error(fmt::format("{}texture {} of {}", place, use.texture, model.textures.size()));
    const auto& texture = model.textures[static_cast<std::size_t>(use.texture)];
    const std::string texture_place = entry("textures", static_cast<std::size_t>(use.texture));
    if (texture.source < 0 || static_cast<std::size_t>(texture.source) >= gltf.images.size())
        throw Error(fmt::format("{}image {} of {}; export the model with PNG or JPEG pictures", texture_place, texture.source,
                                gltf.images.size()));
    look.image = texture.source;
    look.texcoord_set = use.texcoord_set;
    if (texture.sampler >= 0)
    {
        if (static_cast<std::size_t>(texture.sampler) >= model.samplers.size())
            throw Error(fmt::format("{}sampler {} of {}", texture_place, texture.sampler, model.samplers.size()));
        const auto& sampler = model.samplers[static_cast<std::size_t>(texture.sampler)];
        look.material.wrap_u = wrap_of(sampler.wrapS, texture_place);
        look.material.wrap_v = wrap_of(sampler.wrapT, texture_place);
    }
    if (use.transform != nullptr)
    {
        look.picture_from_uv = transform_of(*use.transform, place + "KHR_texture_transform: ");
        look.texcoord_set = integer_or(*use.transform, "texCoord", look.texcoord_set);
    }
}

const tinygltf::Value* find(const tinygltf::ExtensionMap& extensions, const char* name)
{
    const auto found = extensions.find(name);
    return found == extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
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

bool begins_with(std::span<const std::byte> bytes, std::string_view signature)
{
    return bytes.size() > signature.size() && std::memcmp(bytes.data(), signature.data(), signature.size()) == 0;
}

}  // namespace

GltfLook look_of(const GltfFile& gltf, int material, bool with_pictures)
{
    GltfLook look;
    if (material == -1)
        return look;
    if (material < 0 || static_cast<std::size_t>(material) >= gltf.model.materials.size())
        throw Error(fmt::format("material {} of {}", material, gltf.model.materials.size()));
    const auto number = static_cast<std::size_t>(material);
    const auto& source = gltf.model.materials[number];
    const std::string place = entry("materials", number);
    look.material.name = source.name;
    if (const auto* const older = find(source.extensions, "KHR_materials_pbrSpecularGlossiness"))
    {
        take_specular_glossiness(gltf, *older, place, with_pictures, look);
        return look;
    }
    const auto& pbr = source.pbrMetallicRoughness;
    look.material.color = color_of(pbr.baseColorFactor.data());
    if (with_pictures && pbr.baseColorTexture.index != -1)
        take_texture(gltf,
                     {pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord,
                      find(pbr.baseColorTexture.extensions, "KHR_texture_transform")},
                     place, look);
    return look;
}

int GltfPictures::number_of(int image)
{
    const auto found = numbers_.find(image);
    return found != numbers_.end() ? found->second
                                   : numbers_.emplace(image, added(static_cast<std::size_t>(image))).first->second;
}

int GltfPictures::added(std::size_t image)
{
    const fresco::gltf::GltfImage& source = gltf_.images[image];
    const std::string place = entry("images", image);
    const std::string name = fmt::format("{}: image {}", file_.string(), image);
    if (source.buffer_view >= 0)
        return added_view(static_cast<std::size_t>(source.buffer_view), name, place);
    if (fresco::gltf::is_data_uri(source.uri))
        return added({name, {}, fresco::gltf::data_uri_bytes(source.uri, place)}, place);
    const auto file = folder_.find(fresco::gltf::decoded_uri(source.uri), place + "uri", shape_only);
    const auto [same, is_new] = of_files_.try_emplace(std::filesystem::canonical(file), next());
    if (is_new)
    {
        model_.pictures.push_back({file.string(), file, {}});
        model_.files_read.push_back(file);
    }
    return same->second;
}

int GltfPictures::added_view(std::size_t view, const std::string& name, const std::string& place)
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

int GltfPictures::added(FilePicture picture, const std::string& place)
{
    if (!begins_with(picture.bytes, "\x89PNG") && !begins_with(picture.bytes, "\xFF\xD8\xFF"))
        throw Error(place + "neither PNG nor JPEG; export the model with PNG or JPEG pictures");
    model_.pictures.push_back(std::move(picture));
    return next() - 1;
}

}  // namespace scan_mesh
