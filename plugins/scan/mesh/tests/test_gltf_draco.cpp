#include "bumpy_model.h"
#include "catch.h"

#include <fresco/error.h>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

using namespace fresco;
using namespace model_samples;
using scan_mesh::FileModel;

namespace
{

struct DracoSample
{
    GltfSample sample;
    std::size_t stream_begin = 0;
    std::size_t stream_bytes = 0;
};

/// The bumpy model as Draco's encoder packs it, positions in 16 bits, texture coordinates in 14.
DracoSample draco_packed(int method)
{
    BumpyModel model;
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(model.indices.size() / 3));
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int texcoord = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
    for (std::size_t i = 0; i < model.indices.size(); i += 3)
    {
        const draco::FaceIndex face(static_cast<std::uint32_t>(i / 3));
        const auto p = [&](std::size_t k) { return &model.positions[3 * model.indices[i + k]]; };
        const auto uv = [&](std::size_t k) { return &model.texcoords[2 * model.indices[i + k]]; };
        builder.SetAttributeValuesForFace(position, face, p(0), p(1), p(2));
        builder.SetAttributeValuesForFace(texcoord, face, uv(0), uv(1), uv(2));
    }
    const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 16);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 14);
    draco::EncoderBuffer buffer;
    REQUIRE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());

    DracoSample result{model.sample, model.sample.binary.size(), buffer.size()};
    const int view = result.sample.add_view(std::vector<char>(buffer.data(), buffer.data() + buffer.size()));
    // Removes the views of POSITION, TEXCOORD_0 and the indices; the first accessor is another triangle's.
    for (std::size_t i = 1; i < 4; ++i)
        std::erase_if(result.sample.accessors[i].as_map(), [](const auto& entry) { return entry.first == "bufferView"; });
    const auto id = [&](int attribute) { return static_cast<int>(mesh->attribute(attribute)->unique_id()); };
    model.primitive.set(
        "extensions",
        Value::Map{{"KHR_draco_mesh_compression",
                    Value::Map{{"bufferView", view},
                               {"attributes", Value::Map{{"POSITION", id(position)}, {"TEXCOORD_0", id(texcoord)}}}}}});
    model.sample = result.sample;
    for (const char* key : {"extensionsUsed", "extensionsRequired"})
        model.sample.rest.set(key, Value::List{"KHR_draco_mesh_compression"});
    result.sample = model.finished();
    return result;
}

}  // namespace

TEST_CASE("KHR_draco_mesh_compression: the model that was packed, by both of its methods", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    const FileModel plain = read_sample(BumpyModel().finished(), folder);
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    {
        const FileModel same = read_sample(draco_packed(method).sample, folder);
        CHECK(same.mesh.positions.size() == plain.mesh.positions.size());
        CHECK(surface_of(same) == surface_of(plain));
    }
}

TEST_CASE("KHR_draco_mesh_compression: a file of gltf-transform has the surface that was packed", "[scan.mesh]")
{
    check_bumpy(scan_mesh::read_file_model(foreign_files() / "gltf_draco/good_draco.glb", true));
}

TEST_CASE("KHR_draco_mesh_compression: damaged streams are refused with the offset", "[scan.mesh]")
{
    const testing::TemporaryFolder folder;
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
    {
        const DracoSample good = draco_packed(method);
        const auto changed = [&](std::size_t at, int byte)
        {
            GltfSample sample = good.sample;
            sample.binary[good.stream_begin + at] = static_cast<std::byte>(byte);
            return testing::error_of([&] { check_mesh(read_sample(sample, folder).mesh, "the model"); });
        };
        const std::string place = "a.glb: meshes[0]: primitives[0]: KHR_draco_mesh_compression: byte ";
        CHECK_THAT(changed(0, 'X'), Contains(place + "0 of the stream: expected DRACO"));
        CHECK_THAT(changed(6, 9), Contains(place + "5 of the stream: Draco 2.9; glTF has 2.2"));
        CHECK_THAT(changed(7, 0), Contains(place + "7 of the stream: expected a mesh of triangles"));
        CHECK_THAT(changed(10, 0x80), Contains(place + "9 of the stream: it has metadata"));
        // The number of triangles, before Draco takes memory for them.
        const std::size_t faces = method == draco::MESH_SEQUENTIAL_ENCODING ? 11 : 13;
        CHECK_THAT(changed(faces, 0x7F), Contains("accessors[3]: it says 594 rows, its Draco stream holds"));
        if (method == draco::MESH_SEQUENTIAL_ENCODING)
        {
            GltfSample many = good.sample;
            for (std::size_t at = 13; at < 18; ++at)  // The number of vertices: 2^32 - 1.
                many.binary[good.stream_begin + at] = static_cast<std::byte>(at < 17 ? 0xFF : 0x0F);
            CHECK_THROWS_WITH(read_sample(many, folder), Contains("bytes that claim 4294967295 vertices and 198 triangles"));
        }
        // Cut, and flipped: an error, or a mesh that can be used.
        for (std::size_t size = 1; size < good.stream_bytes; size += 3)
        {
            GltfSample sample = good.sample;
            sample.views.back().set("byteLength", size);
            CHECK_THROWS_AS(read_sample(sample, folder), Error);
        }
        for (std::size_t at = 0; at < good.stream_bytes; ++at)
            CHECK_NOTHROW(changed(at, std::to_integer<int>(good.sample.binary[good.stream_begin + at]) ^ 0x5A));
        GltfSample sample = good.sample;
        sample.accessors[1].set("count", 119);
        CHECK_THROWS_WITH(read_sample(sample, folder), Contains("accessors[1]: it says 119 rows, its Draco stream holds 120"));
        sample = good.sample;
        sample.accessors[2].set("type", "VEC3");
        CHECK_THROWS_WITH(read_sample(sample, folder), Contains("accessors[2]: TEXCOORD_0"));
    }
}
