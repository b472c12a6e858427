#pragma once

#include "stored_png.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>
#include <fresco/value.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// \file Small textured models as files, written value by value.

namespace model_samples
{

using fresco::Value;

/// Collects the parts of a GLB or glTF file.
class GltfSample
{
  public:
    template <class T>
    int add_view(const std::vector<T>& values)
    {
        const auto bytes = std::as_bytes(std::span(values));
        views.emplace_back(Value::Map{{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
        binary.insert(binary.end(), bytes.begin(), bytes.end());
        binary.resize((binary.size() + 3) / 4 * 4);
        return static_cast<int>(views.size() - 1);
    }

    /// 5126: float, 5125: uint, 5123: ushort, 5121: ubyte.
    template <class T>
    int add_accessor(const std::vector<T>& values, const char* type, int component_type, std::size_t count,
                     bool normalized = false)
    {
        accessors.emplace_back(
            Value::Map{{"bufferView", add_view(values)}, {"componentType", component_type}, {"count", count}, {"type", type}});
        if (normalized)
            accessors.back().set("normalized", true);
        return static_cast<int>(accessors.size() - 1);
    }

    Value document() const
    {
        Value result = rest;
        result.set("asset", Value::Map{{"version", "2.0"}});
        result.set("accessors", accessors);
        result.set("bufferViews", views);
        if (result.find("buffers") == nullptr)
            result.set("buffers", Value::List{Value::Map{{"byteLength", binary.size()}}});
        return result;
    }

    std::vector<std::byte> glb() const { return assembled(fresco::to_json(document())); }

    std::vector<std::byte> assembled(std::string text) const
    {
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::byte> file;
        const auto word = [&](std::size_t value)
        {
            for (unsigned shift = 0; shift < 32; shift += 8)
                file.push_back(static_cast<std::byte>(value >> shift & 255U));
        };
        word(0x46546C67);
        word(2);
        word(28 + text.size() + binary.size());
        word(text.size());
        word(0x4E4F534A);
        const auto raw = std::as_bytes(std::span(text));
        file.insert(file.end(), raw.begin(), raw.end());
        word(binary.size());
        word(0x004E4942);
        file.insert(file.end(), binary.begin(), binary.end());
        return file;
    }

    Value::List views;
    Value::List accessors;
    std::vector<std::byte> binary;
    Value rest{Value::Map{}};  ///< Everything else of the document.
};

/// One triangle, (0,0,0), (1,0,0), (0,1,0), shown by one node: `primitive` takes more entries, `sample.rest` too.
struct TriangleSample
{
    GltfSample sample;
    Value primitive{Value::Map{}};

    TriangleSample()
    {
        position = sample.add_accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 5126, 3);
        attributes.set("POSITION", position);
        sample.rest.set("nodes", Value::List{Value::Map{{"mesh", 0}}});
        sample.rest.set("scenes", Value::List{Value::Map{{"nodes", Value::List{0}}}});
    }

    /// The sample with its mesh.
    GltfSample finished() const
    {
        GltfSample result = sample;
        Value whole = primitive;
        whole.set("attributes", attributes);
        result.rest.set("meshes", Value::List{Value::Map{{"primitives", Value::List{whole}}}});
        return result;
    }

    int position = 0;
    Value attributes{Value::Map{}};
};

/// The axis-aligned box from 0 to (4, 3, 2): each side has its own corners, counter-clockwise from outside, and texcoords from
/// (0,0) to (1,1) in this order: lower left, lower right, upper right, upper left.
struct Box
{
    static constexpr std::size_t sides = 6;

    static std::array<fresco::Vec3f, 4> corners(std::size_t side)
    {
        using V = fresco::Vec3f;
        static const std::array<std::array<V, 4>, sides> all{{{V{0, 0, 0}, V{0, 0, 2}, V{0, 3, 2}, V{0, 3, 0}},
                                                              {V{4, 0, 2}, V{4, 0, 0}, V{4, 3, 0}, V{4, 3, 2}},
                                                              {V{0, 0, 0}, V{4, 0, 0}, V{4, 0, 2}, V{0, 0, 2}},
                                                              {V{0, 3, 2}, V{4, 3, 2}, V{4, 3, 0}, V{0, 3, 0}},
                                                              {V{4, 0, 0}, V{0, 0, 0}, V{0, 3, 0}, V{4, 3, 0}},
                                                              {V{0, 0, 2}, V{4, 0, 2}, V{4, 3, 2}, V{0, 3, 2}}}};
        return all[side];
    }

    static fresco::Vec3f point(std::size_t side, float u, float v)
    {
        const auto c = corners(side);
        return c[0] + (c[1] - c[0]) * u + (c[3] - c[0]) * v;
    }

    /// Color of the quarter of a side's picture that holds (u, v).
    static fresco::Rgb8 color(std::size_t side, float u, float v)
    {
        return {static_cast<std::uint8_t>(30 + 40 * side), static_cast<std::uint8_t>(u < 0.5F ? 60 : 180),
                static_cast<std::uint8_t>(v < 0.5F ? 50 : 200)};
    }

    static fresco::Raster8 picture(std::size_t side, int size = 16)
    {
        return fresco::testing::picture(size, size,
                                        [&](int x, int y, int c)
                                        {
                                            const auto at = [&](int i)
                                            { return (static_cast<float>(i) + 0.5F) / static_cast<float>(size); };
                                            return color(side, at(x), 1 - at(y))[static_cast<std::size_t>(c)];
                                        });
    }
};

inline constexpr std::array<std::array<float, 2>, 4> corner_uvs{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

/// Writes box.glb: six primitives, materials and pictures inside.
inline std::filesystem::path write_glb_box(const std::filesystem::path& folder)
{
    GltfSample glb;
    Value::List primitives, materials, textures, images;
    for (std::size_t side = 0; side < Box::sides; ++side)
    {
        std::vector<float> positions, uvs;
        for (std::size_t i = 0; i < 4; ++i)
        {
            const auto p = Box::corners(side)[i];
            positions.insert(positions.end(), {p.x, p.y, p.z});
            uvs.insert(uvs.end(), {corner_uvs[i][0], 1 - corner_uvs[i][1]});
        }
        const int position = glb.add_accessor(positions, "VEC3", 5126, 4);
        const int uv = glb.add_accessor(uvs, "VEC2", 5126, 4);
        const int indices = glb.add_accessor(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", 5123, 6);
        primitives.emplace_back(Value::Map{
            {"attributes", Value::Map{{"POSITION", position}, {"TEXCOORD_0", uv}}}, {"indices", indices}, {"material", side}});
        materials.emplace_back(Value::Map{
            {"name", "side " + std::to_string(side)},
            {"pbrMetallicRoughness", Value::Map{{"baseColorTexture", Value::Map{{"index", side}}}, {"metallicFactor", 0}}}});
        textures.emplace_back(Value::Map{{"source", side}});
        images.emplace_back(
            Value::Map{{"bufferView", glb.add_view(stored_png::encode(Box::picture(side)))}, {"mimeType", "image/png"}});
    }
    glb.rest.set("scene", 0);
    glb.rest.set("scenes", Value::List{Value::Map{{"nodes", Value::List{0}}}});
    glb.rest.set("nodes", Value::List{Value::Map{{"mesh", 0}}});
    glb.rest.set("meshes", Value::List{Value::Map{{"primitives", std::move(primitives)}}});
    glb.rest.set("materials", std::move(materials));
    glb.rest.set("textures", std::move(textures));
    glb.rest.set("images", std::move(images));
    fresco::write_file(folder / "box.glb", glb.glb());
    return folder / "box.glb";
}

inline void write_pictures(const std::filesystem::path& folder)
{
    for (std::size_t side = 0; side < Box::sides; ++side)
        fresco::write_file(folder / ("side " + std::to_string(side) + ".png"),
                           stored_png::Codec().encode_png(Box::picture(side)));
}

/// Writes box.obj, box.mtl and six pictures. The texcoords are whole numbers away from [0,1].
inline std::filesystem::path write_obj_box(const std::filesystem::path& folder)
{
    write_pictures(folder);
    std::string obj = "# a box\nmtllib box.mtl\nvt 2 -1\nvt 3 -1\nvt 3 0\nvt 2 0\n";
    std::string mtl;
    const auto number = [](float v) { return std::to_string(static_cast<int>(v)); };
    for (std::size_t side = 0; side < Box::sides; ++side)
    {
        const std::string name = "side " + std::to_string(side);
        mtl += "newmtl " + name + "\nKd 0.8 0.8 0.8\nillum 1\nmap_Kd " + name + ".png\n";
        for (const auto& p : Box::corners(side))
            obj += "v " + number(p.x) + " " + number(p.y) + " " + number(p.z) + "\n";
        obj += "usemtl " + name + "\nf -4/1 -3/2 -2/3 -1/4\n";
    }
    fresco::write_file(folder / "box.obj", obj);
    fresco::write_file(folder / "box.mtl", mtl);
    return folder / "box.obj";
}

/// Writes box.ply, ASCII, with texcoords per face and a picture per face, and six pictures.
inline std::filesystem::path write_ply_box(const std::filesystem::path& folder)
{
    write_pictures(folder);
    std::string ply = "ply\nformat ascii 1.0\n";
    for (std::size_t side = 0; side < Box::sides; ++side)
        ply += "comment TextureFile side " + std::to_string(side) + ".png\n";
    ply += "element vertex 24\nproperty float x\nproperty float y\nproperty float z\nelement face 6\n"
           "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nend_header\n";
    for (std::size_t side = 0; side < Box::sides; ++side)
        for (const auto& p : Box::corners(side))
            ply += std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    for (std::size_t side = 0; side < Box::sides; ++side)
    {
        ply += "4";
        for (std::size_t i = 0; i < 4; ++i)
            ply += " " + std::to_string(4 * side + i);
        ply += " 8 0 0 1 0 1 1 0 1 " + std::to_string(side) + "\n";
    }
    fresco::write_file(folder / "box.ply", ply);
    return folder / "box.ply";
}

}  // namespace model_samples
