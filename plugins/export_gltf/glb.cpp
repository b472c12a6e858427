#include "glb.h"

#include <fresco/error.h>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#include <fstream>
#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>

using namespace fresco;

namespace
{
/// Fills a model with one buffer, whose parts begin at multiples of four.
class ModelBuilder
{
  public:
    ModelBuilder()
    {
        model.asset.version = "2.0";
        model.asset.generator = "fresco";
        model.buffers.emplace_back();
    }

    int add_view(const void* bytes, std::size_t count, int target)
    {
        std::vector<unsigned char>& data = model.buffers[0].data;
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = data.size();
        view.byteLength = count;
        view.target = target;
        const auto* first = static_cast<const unsigned char*>(bytes);
        data.insert(data.end(), first, first + count);
        data.resize((data.size() + 3) / 4 * 4, 0);
        model.bufferViews.push_back(std::move(view));
        return static_cast<int>(model.bufferViews.size()) - 1;
    }

    template <class T>
    int add_accessor(const std::vector<T>& values, int target, int component_type, int type)
    {
        tinygltf::Accessor accessor;
        accessor.bufferView = add_view(values.data(), values.size() * sizeof(T), target);
        accessor.count = values.size();
        accessor.componentType = component_type;
        accessor.type = type;
        model.accessors.push_back(std::move(accessor));
        return static_cast<int>(model.accessors.size()) - 1;
    }

    int add_floats(const std::vector<Vec3f>& values)
    {
        return add_accessor(values, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
    }

    tinygltf::Model model;
};

void set_bounds(tinygltf::Accessor& accessor, const std::vector<Vec3f>& positions)
{
    constexpr float far = std::numeric_limits<float>::infinity();
    Vec3f low{far, far, far};
    Vec3f high{-far, -far, -far};
    for (const Vec3f p : positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    accessor.minValues = {double{low.x}, double{low.y}, double{low.z}};
    accessor.maxValues = {double{high.x}, double{high.y}, double{high.z}};
}

std::vector<Vec2f> flipped(std::vector<Vec2f> texcoords)
{
    for (Vec2f& uv : texcoords)
        uv.y = 1 - uv.y;
    return texcoords;
}

void add_mesh(ModelBuilder& builder, const WeldedMesh& mesh, const GlbOptions& options)
{
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    primitive.indices = builder.add_accessor(mesh.indices, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
                                             TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR);
    const int positions = builder.add_floats(mesh.positions);
    set_bounds(builder.model.accessors[static_cast<std::size_t>(positions)], mesh.positions);
    primitive.attributes["POSITION"] = positions;
    if (options.material == GltfMaterial::pbr)
        primitive.attributes["NORMAL"] = builder.add_floats(mesh.normals);
    primitive.attributes["TEXCOORD_0"] = builder.add_accessor(flipped(mesh.texcoords), TINYGLTF_TARGET_ARRAY_BUFFER,
                                                              TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC2);
    tinygltf::Mesh gltf_mesh;
    gltf_mesh.name = "room";
    gltf_mesh.primitives.push_back(std::move(primitive));
    builder.model.meshes.push_back(std::move(gltf_mesh));
}

void add_material(ModelBuilder& builder, const std::vector<std::byte>& image, const GlbOptions& options)
{
    tinygltf::Image picture;
    picture.bufferView = builder.add_view(image.data(), image.size(), 0);
    picture.mimeType = options.image_type;
    builder.model.images.push_back(std::move(picture));

    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
    sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    builder.model.samplers.push_back(std::move(sampler));

    tinygltf::Texture texture;
    texture.sampler = 0;
    texture.source = 0;
    builder.model.textures.push_back(std::move(texture));

    tinygltf::Material material;
    material.name = "texture";
    material.pbrMetallicRoughness.baseColorTexture.index = 0;
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 1;
    if (options.material == GltfMaterial::unlit)
    {
        material.extensions["KHR_materials_unlit"] = tinygltf::Value(tinygltf::Value::Object{});
        builder.model.extensionsUsed.emplace_back("KHR_materials_unlit");
    }
    builder.model.materials.push_back(std::move(material));
}

void add_scene(ModelBuilder& builder, GltfUp up)
{
    tinygltf::Node node;
    node.name = "room";
    node.mesh = 0;
    const double half = std::sqrt(0.5);
    if (up == GltfUp::z)
        node.rotation = {-half, 0, 0, half};  // x, y, z, w: a quarter turn about -X
    else if (up == GltfUp::minus_y)
        node.rotation = {1, 0, 0, 0};  // half a turn about X
    builder.model.nodes.push_back(std::move(node));
    tinygltf::Scene scene;
    scene.nodes.push_back(0);
    builder.model.scenes.push_back(std::move(scene));
    builder.model.defaultScene = 0;
}
}  // namespace

std::vector<std::byte> make_glb(const WeldedMesh& mesh, const std::vector<std::byte>& image, const GlbOptions& options)
{
    constexpr std::size_t largest = std::numeric_limits<std::uint32_t>::max() - 65536;  // leaves room for the JSON part
    const std::size_t bytes = mesh.indices.size() * 4 + mesh.positions.size() * 32 + image.size();
    if (bytes > largest)
        throw Error("the mesh and its picture take " + std::to_string(bytes >> 20U) +
                    " MiB, a GLB file holds at most 4096: decimate the mesh or set max_texture_px");
    ModelBuilder builder;
    add_mesh(builder, mesh, options);
    add_material(builder, image, options);
    add_scene(builder, options.up);

    std::ostringstream stream(std::ios::binary);
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&builder.model, stream, false, true))
        throw Error("the glTF writer failed");
    const std::string text = std::move(stream).str();
    std::vector<std::byte> glb(text.size());
    std::memcpy(glb.data(), text.data(), text.size());
    return glb;
}
