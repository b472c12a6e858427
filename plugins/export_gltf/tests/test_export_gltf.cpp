#include "glb.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cstring>

using namespace fresco;

namespace
{
/// The two chunks of a GLB file.
struct Glb
{
    nlohmann::json json;
    std::vector<std::byte> binary;

    explicit Glb(const std::vector<std::byte>& file)
    {
        REQUIRE(word(file, 0) == 0x46546C67U);
        REQUIRE(word(file, 4) == 2);
        REQUIRE(word(file, 8) == file.size());
        const std::size_t json_bytes = word(file, 12);
        REQUIRE(json_bytes % 4 == 0);
        REQUIRE(word(file, 16) == 0x4E4F534AU);
        const auto* text = reinterpret_cast<const char*>(file.data() + 20);
        json = nlohmann::json::parse(text, text + json_bytes);
        REQUIRE(word(file, 24 + json_bytes) == 0x004E4942U);
        REQUIRE(word(file, 20 + json_bytes) == file.size() - 28 - json_bytes);
        binary.assign(file.begin() + static_cast<std::ptrdiff_t>(28 + json_bytes), file.end());
    }

    static std::uint32_t word(const std::vector<std::byte>& bytes, std::size_t at)
    {
        std::uint32_t v = 0;
        std::memcpy(&v, &bytes.at(at), 4);
        return v;
    }

    template <class T>
    std::vector<T> values(int accessor, std::size_t per_element) const
    {
        const auto& a = json.at("accessors").at(static_cast<std::size_t>(accessor));
        const auto& view = json.at("bufferViews").at(a.at("bufferView").get<std::size_t>());
        std::vector<T> result(a.at("count").get<std::size_t>() * per_element);
        std::memcpy(result.data(), binary.data() + view.value("byteOffset", std::size_t{0}), result.size() * sizeof(T));
        return result;
    }

    const nlohmann::json& primitive() const { return json.at("meshes").at(0).at("primitives").at(0); }
    const nlohmann::json& view_of(const char* attribute) const
    {
        const std::size_t accessor = primitive().at("attributes").at(attribute).get<std::size_t>();
        return json.at("bufferViews").at(json.at("accessors").at(accessor).at("bufferView").get<std::size_t>());
    }
};

TexturedMesh square()
{
    TexturedMesh textured;
    textured.mesh.positions = {{0.1F, 0.2F, 0.3F}, {1, 0, 0}, {1, 1, -2}, {0, 1, 0}};
    textured.mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 2}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 0.75F}, {1, 0}, {1, 1}, {1, 1}};
    textured.image = Image(Raster8(8, 8, 3, 77));
    textured.image.pixels.at(2, 1, 0) = 200;
    return textured;
}

struct Exported
{
    std::vector<std::byte> file;
    std::vector<std::string> names;
    Value report;
};

Exported exported(const Value& options, const TexturedMesh& textured = square())
{
    const auto made = testing::make_from_plugin(FRESCO_PLUGIN_FILE, "export.gltf");
    testing::TemporaryFolder folder;
    testing::TestRun run;
    testing::TestFactory factory;
    factory.add("image.opencv", [] { return std::make_shared<stored_png::Codec>(); });
    Value all = options;
    all.set("images", Value::Map{{"type", "image.opencv"}});
    testing::run_stage(dynamic_cast<Stage&>(*made), all, {{"mesh", std::make_shared<TexturedMesh>(textured)}}, folder.path(), run,
                       factory);
    const auto files = Files::load({folder.path() / "files", folder.path()});
    return {read_file(folder.path() / "files" / files->names.at(0)), files->names, run.reported};
}
}  // namespace

TEST_CASE("the file holds the mesh in glTF's conventions")
{
    const Exported result = exported(Value::Map{});
    CHECK(result.names == std::vector<std::string>{"room.glb"});
    const Glb glb(result.file);
    const auto indices = glb.values<std::uint32_t>(glb.primitive().at("indices").get<int>(), 1);
    const auto positions = glb.values<float>(glb.primitive().at("attributes").at("POSITION").get<int>(), 3);
    const auto texcoords = glb.values<float>(glb.primitive().at("attributes").at("TEXCOORD_0").get<int>(), 2);
    const Mesh mesh = square().mesh;
    REQUIRE(indices.size() == 9);
    for (std::size_t corner = 0; corner < 9; ++corner)
    {
        const Vec3f p = mesh.positions[mesh.triangles[corner / 3][corner % 3]];
        CHECK(positions[3 * indices[corner]] == p.x);
        CHECK(positions[3 * indices[corner] + 1] == p.y);
        CHECK(positions[3 * indices[corner] + 2] == p.z);
        CHECK(texcoords[2 * indices[corner]] == mesh.texcoords[corner].x);
        CHECK(texcoords[2 * indices[corner] + 1] == 1 - mesh.texcoords[corner].y);
    }
    const auto& bounds = glb.json.at("accessors").at(glb.primitive().at("attributes").at("POSITION").get<std::size_t>());
    CHECK(bounds.at("min").get<std::vector<float>>() == std::vector<float>{0, 0, -2});
    CHECK(bounds.at("max").get<std::vector<float>>() == std::vector<float>{1, 1, 0.3F});
    CHECK(glb.view_of("POSITION").at("target") == 34962);
    CHECK(glb.json.at("bufferViews").at(0).at("target") == 34963);
    CHECK(result.report.at("triangles").as_int() == 3);
}

TEST_CASE("the picture is embedded as it was encoded")
{
    const Exported result = exported(Value::Map{});
    const Glb glb(result.file);
    const auto& image = glb.json.at("images").at(0);
    CHECK(image.at("mimeType") == "image/png");
    CHECK_FALSE(image.contains("uri"));
    const auto& view = glb.json.at("bufferViews").at(image.at("bufferView").get<std::size_t>());
    CHECK_FALSE(view.contains("target"));
    const auto offset = static_cast<std::ptrdiff_t>(view.at("byteOffset").get<std::size_t>());
    const auto bytes = view.at("byteLength").get<std::ptrdiff_t>();
    const stored_png::Codec codec;
    CHECK(std::vector<std::byte>(glb.binary.begin() + offset, glb.binary.begin() + offset + bytes) ==
          codec.encode_png(square().image.pixels));
    CHECK(glb.json.at("samplers").at(0).at("minFilter") == 9987);
    CHECK(glb.json.at("samplers").at(0).at("wrapS") == 33071);
}

TEST_CASE("unlit is declared, pbr brings normals")
{
    const Glb unlit(exported(Value::Map{}).file);
    CHECK(unlit.json.at("extensionsUsed") == nlohmann::json{"KHR_materials_unlit"});
    CHECK(unlit.json.at("materials").at(0).at("extensions").at("KHR_materials_unlit").is_object());
    CHECK_FALSE(unlit.primitive().at("attributes").contains("NORMAL"));
    const Glb lit(exported(Value::Map{{"material", "pbr"}}).file);
    CHECK_FALSE(lit.json.contains("extensionsUsed"));
    CHECK_FALSE(lit.json.at("materials").at(0).contains("extensions"));
    CHECK(lit.primitive().at("attributes").contains("NORMAL"));
}

TEST_CASE("the node turns the world's up to +Y and leaves the positions")
{
    const auto turned = [](const char* up, Vec3d p)
    {
        const Glb glb(exported(Value::Map{{"up", up}}).file);
        const auto& node = glb.json.at("nodes").at(0);
        const auto q = node.value("rotation", std::vector<double>{0, 0, 0, 1});
        const Vec3d axis{q[0], q[1], q[2]};
        // v' = v + 2w (a x v) + 2 a x (a x v)
        return p + cross(axis, p) * (2 * q[3]) + cross(axis, cross(axis, p)) * 2.0;
    };
    CHECK(length(turned("z", {0, 0, 1}) - Vec3d{0, 1, 0}) < 1e-9);
    CHECK(length(turned("z", {1, 0, 0}) - Vec3d{1, 0, 0}) < 1e-9);
    CHECK(length(turned("-y", {0, -1, 0}) - Vec3d{0, 1, 0}) < 1e-9);
    CHECK(length(turned("keep", {0, 0, 1}) - Vec3d{0, 0, 1}) < 1e-9);
    CHECK_FALSE(Glb(exported(Value::Map{}).file).json.at("nodes").at(0).contains("rotation"));
}

TEST_CASE("a picture over the limit is shrunk")
{
    const Exported result = exported(Value::Map{{"max_texture_px", 4}});
    CHECK(result.report.at("texture_px").as_int() == 4);
    CHECK(exported(Value::Map{{"max_texture_px", 9}}).report.at("texture_px").as_int() == 8);
}

TEST_CASE("what cannot be exported is refused")
{
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.gltf"}}), Catch::Contains("does not end in .glb"));
    TexturedMesh bare = square();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(exported(Value::Map{}, bare), Catch::Contains("no texcoords"));
    CHECK(exported(Value::Map{{"path", "deep/er/a b.glb"}}).names.at(0) == "deep/er/a b.glb");
}
