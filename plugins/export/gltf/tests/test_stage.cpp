#include "catch.h"
#include "exported_files.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/reader.h>
#include <fresco/relief.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/texture_pictures.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

using namespace fresco;
using namespace exported_files;

namespace
{

/// The two chunks of a GLB file, read without the plugin.
struct Glb
{
    nlohmann::json json;
    std::string binary;

    explicit Glb(const std::string& file)
    {
        REQUIRE(word(file, 0) == 0x46546C67U);
        REQUIRE(word(file, 4) == 2);
        REQUIRE(word(file, 8) == file.size());
        const std::size_t json_bytes = word(file, 12);
        REQUIRE(json_bytes % 4 == 0);
        REQUIRE(word(file, 16) == 0x4E4F534AU);
        json = nlohmann::json::parse(file.substr(20, json_bytes));
        REQUIRE(word(file, 24 + json_bytes) == 0x004E4942U);
        REQUIRE(word(file, 20 + json_bytes) == file.size() - 28 - json_bytes);
        binary = file.substr(28 + json_bytes);
    }

    static std::uint32_t word(const std::string& bytes, std::size_t at)
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
    /// The rows of one of the mesh's attributes.
    template <class Row>
    std::vector<Row> rows(const char* attribute) const
    {
        return values<Row>(primitive().at("attributes").at(attribute).get<int>(), 1);
    }
    std::string picture(std::size_t number) const
    {
        const auto& view = json.at("bufferViews").at(json.at("images").at(number).at("bufferView").get<std::size_t>());
        return binary.substr(view.at("byteOffset").get<std::size_t>(), view.at("byteLength").get<std::size_t>());
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

Exported exported_from(const Value& options, const testing::Inputs& inputs, const Value& origin = Value::Map{})
{
    return exported_by("export.gltf", options, inputs, origin);
}

Exported exported(const Value& options, const TexturedMesh& textured = square())
{
    return exported_from(options, {{"textured_mesh", std::make_shared<TexturedMesh>(textured)}});
}

}  // namespace

TEST_CASE("the file holds the mesh in glTF's conventions")
{
    const Exported result = exported(Value::Map{});
    CHECK(result.names == std::vector<std::string>{"room.glb"});
    const Glb glb(result.file);
    const auto indices = glb.values<std::uint16_t>(glb.primitive().at("indices").get<int>(), 1);
    const auto positions = glb.rows<Vec3f>("POSITION");
    const auto texcoords = glb.rows<Vec2f>("TEXCOORD_0");
    const Mesh mesh = square().mesh;
    REQUIRE(indices.size() == 9);
    for (std::size_t corner = 0; corner < 9; ++corner)
    {
        CHECK(positions[indices[corner]] == mesh.positions[mesh.triangles[corner / 3][corner % 3]]);
        CHECK(texcoords[indices[corner]] == Vec2f{mesh.texcoords[corner].x, 1 - mesh.texcoords[corner].y});
    }
    const auto& bounds = glb.json.at("accessors").at(glb.primitive().at("attributes").at("POSITION").get<std::size_t>());
    CHECK(bounds.at("min").get<std::vector<float>>() == std::vector<float>{0, 0, -2});
    CHECK(bounds.at("max").get<std::vector<float>>() == std::vector<float>{1, 1, 0.3F});
    CHECK(result.report.at("triangles").as_int() == 3);
    CHECK_THAT(result.messages.at(1), Catch::StartsWith("room.glb: ") && Contains("3 triangles, picture of 8 x 8 in "));
}

TEST_CASE("the picture is embedded as it was encoded; unlit is declared, pbr brings normals")
{
    TexturedMesh colored = square();
    colored.mesh.colors = {{0, 1, 2}, {30, 90, 188}, {254, 255, 253}, {7, 77, 177}};
    const Glb unlit(exported(Value::Map{}, colored).file);
    CHECK(unlit.json.at("images").at(0).at("mimeType") == "image/png");
    CHECK(holds_png(unlit.picture(0), square().image.pixels));
    CHECK(unlit.json.at("samplers").at(0).at("wrapS") == 33071);
    CHECK(unlit.json.at("extensionsUsed") == nlohmann::json{"KHR_materials_unlit"});
    CHECK(unlit.json.at("materials").at(0).at("extensions").at("KHR_materials_unlit").is_object());
    // Colors would darken the picture.
    CHECK(unlit.primitive().at("attributes").size() == 2);
    const Glb lit(exported(Value::Map{{"material", "pbr"}}).file);
    CHECK_FALSE(lit.json.contains("extensionsUsed"));
    CHECK(lit.primitive().at("attributes").contains("NORMAL"));
    CHECK(exported(Value::Map{{"max_texture_px", 4}}).report.at("texture_px").as_int() == 4);
}

namespace
{
Vec3d turned_by_node(const Exported& of, Vec3d p)
{
    const auto q = Glb(of.file).json.at("nodes").at(0).value("rotation", std::vector<double>{0, 0, 0, 1});
    const Vec3d axis{q[0], q[1], q[2]};
    // v' = v + 2w (a x v) + 2 a x (a x v)
    return p + cross(axis, p) * (2 * q[3]) + cross(axis, cross(axis, p)) * 2.0;
}
}  // namespace

TEST_CASE("the node turns the world's up to +Y and leaves the positions")
{
    const auto turned = [](const char* up, Vec3d p) { return turned_by_node(exported(Value::Map{{"up", up}}), p); };
    CHECK(length(turned("z", {0, 0, 1}) - Vec3d{0, 1, 0}) < 1e-9);
    CHECK(length(turned("z", {1, 0, 0}) - Vec3d{1, 0, 0}) < 1e-9);
    CHECK(length(turned("-y", {0, -1, 0}) - Vec3d{0, 1, 0}) < 1e-9);
    CHECK(length(turned("x", {1, 0, 0}) - Vec3d{0, 1, 0}) < 1e-9);
    CHECK(length(turned("keep", {0, 0, 1}) - Vec3d{0, 0, 1}) < 1e-9);
    // The camera leans by 10 degrees; the floor corrects it.
    const auto floor = std::make_shared<TexturedMesh>(square());
    floor->mesh = testing::wall();
    for (Vec3f& p : floor->mesh.positions)
        p = {p.x, -p.y, -p.z};
    const auto frames = std::make_shared<Frames>();
    frames->frames.emplace_back().color.world_from_camera =
        testing::looking_at({0, 0, 0}, {0, 1, 0}, {std::sin(0.1745), 0, std::cos(0.1745)});
    const Exported upright = exported_from(Value::Map{}, {{"textured_mesh", floor}, {"frames", frames}});
    CHECK(length(turned_by_node(upright, {0, 0, 1}) - Vec3d{0, 1, 0}) < 1e-6);
    CHECK(upright.report.at("up_plane_deg").as_double() == Approx(10).margin(0.01));
    CHECK_FALSE(Glb(exported(Value::Map{}).file).json.at("nodes").at(0).contains("rotation"));
}

TEST_CASE("asset.extras says how the file was made; origin.gltf reads it from the header, and refuses damage by name")
{
    const auto made = testing::make_from_plugin(FRESCO_PLUGIN_FILE, "origin.gltf");
    const auto* const reader = dynamic_cast<const FileOrigin*>(made.get());
    REQUIRE(reader != nullptr);
    CHECK(reader->extensions() == std::vector<std::string>{".glb"});
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "room.glb";
    const Value figures = Value::Map{{"bytes", std::int64_t{1} << 40U}, {"share", 0.1}, {"name", "\"é<"}, {"up", Value::List{}}};
    const Value origin = Value::Map{
        {"versions", Value::Map{{"fresco", "0.1"}}},
        {"stages", Value::List{Value::Map{{"stage", "export.gltf"}, {"options", Value::Map{}}, {"figures", figures}}}}};
    const testing::Inputs inputs{{"textured_mesh", std::make_shared<TexturedMesh>(square())}};
    const std::string whole = exported_from(Value::Map{}, inputs, origin).file;
    CHECK(Glb(whole).json.at("asset").at("extras") == nlohmann::json::parse(to_json(origin)));
    CHECK_FALSE(Glb(exported_from(Value::Map{}, inputs).file).json.at("asset").contains("extras"));
    TexturedMesh far = square();
    far.mesh.offset_m = {448'000, -5'411'000.5, 0};
    const Exported moved = exported(Value::Map{}, far);
    CHECK(Glb(moved.file).json.at("asset").at("extras").at("offset_m") == std::vector<double>{448'000, -5'411'000.5, 0});
    CHECK(Glb(moved.file).rows<Vec3f>("POSITION") == Glb(whole).rows<Vec3f>("POSITION"));
    CHECK(moved.report.at("offset_m") == Value(Value::List{448'000.0, -5'411'000.5, 0.0}));
    const auto refused = [&](std::string bytes, const std::string& reason)
    {
        write_file(file, bytes);
        CHECK_THROWS_WITH(reader->origin(file), Contains("room.glb: ") && Contains(reason));
    };
    const auto with = [&](std::size_t at, const std::string& bytes)
    { return whole.substr(0, at) + bytes + whole.substr(at + bytes.size()); };
    const std::size_t json_end = whole.find("BIN") - 4;
    for (std::size_t length = 0; length < json_end; length += length < 40 ? 1 : 37)
        refused(whole.substr(0, length), length < 20 ? "is not a binary glTF 2.0 file" : "ends within its JSON chunk");
    refused(with(4, "\1"), "is not a binary glTF 2.0 file");
    refused(with(15, "\x70"), "more than 64 MiB");
    refused(with(20, "["), "JSON");
    refused(exported_from(Value::Map{}, inputs).file, "how it was made");
    write_file(file, whole);
    CHECK(reader->origin(file) == origin);
    CHECK_THROWS_AS(reader->origin(folder.path() / "gone.glb"), MissingInput);
}

namespace
{
Mesh colored_square()
{
    Mesh mesh = square().mesh;
    mesh.colors = {{0, 1, 2}, {30, 90, 188}, {254, 255, 253}, {7, 77, 177}};
    return mesh;
}

Exported exported_mesh(const Value& options, const Mesh& mesh)
{
    return exported_from(options, {{"mesh", std::make_shared<Mesh>(mesh)}});
}
}  // namespace

TEST_CASE("error_share leaves out what a flat surface does not need, in shares of the mesh's longest side")
{
    constexpr std::uint32_t side = 9;
    TexturedMesh flat;
    flat.image = square().image;
    for (std::uint32_t i = 0; i < side * side; ++i)
        flat.mesh.positions.push_back(
            {static_cast<float>(i % side) * 10, static_cast<float>(i / side) * 10, i == 40 ? 0.4F : 0.0F});
    const auto add = [&](std::array<std::uint32_t, 3> corners)
    {
        flat.mesh.triangles.push_back(corners);
        for (const std::uint32_t corner : corners)
            flat.mesh.texcoords.push_back({flat.mesh.positions[corner].x / 80, flat.mesh.positions[corner].y / 80});
    };
    for (std::uint32_t i = 0; i + side < side * side; ++i)
        if (i % side + 1 < side)
        {
            add({i, i + 1, i + side + 1});
            add({i, i + side + 1, i + side});
        }
    const auto highest = [&](double share)
    {
        const Glb glb(exported(Value::Map{{"error_share", share}}, flat).file);
        const auto positions = glb.rows<Vec3f>("POSITION");
        CHECK((positions.size() == side * side) == (share == 0));
        return std::ranges::max(positions, {}, &Vec3f::z).z;
    };
    CHECK(highest(0) == 0.4F);
    CHECK(highest(0.001) == 0.4F);  // 0.08 of 80 m.
    CHECK(highest(0.02) == 0);
}

TEST_CASE("a mesh without a picture keeps its vertex colors to the step")
{
    const Mesh mesh = colored_square();
    const Exported result = exported_mesh(Value::Map{}, mesh);
    const Glb glb(result.file);
    const auto positions = glb.rows<Vec3f>("POSITION");
    const auto colors = glb.rows<std::array<std::uint16_t, 4>>("COLOR_0");
    const auto indices = glb.values<std::uint16_t>(glb.primitive().at("indices").get<int>(), 1);
    REQUIRE(indices.size() == 9);
    for (std::size_t corner = 0; corner < 9; ++corner)
    {
        const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
        CHECK(positions[indices[corner]] == mesh.positions[vertex]);
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(texturing::from_linear(colors[indices[corner]][c] / 65535.0) == mesh.colors[vertex][c]);
    }
    CHECK(glb.rows<Vec2f>("TEXCOORD_0").size() == positions.size());
    CHECK_FALSE(glb.primitive().at("attributes").contains("NORMAL"));
    CHECK(glb.json.at("materials").at(0).at("extensions").contains("KHR_materials_unlit"));
    CHECK_FALSE(glb.json.contains("images"));
}

TEST_CASE("a mesh without any color is lit, so that its shape shows")
{
    Mesh mesh = square().mesh;
    mesh.texcoords.clear();
    const Glb glb(exported_mesh(Value::Map{}, mesh).file);
    CHECK(glb.rows<Vec3f>("POSITION").size() == 4);
    const auto normals = glb.rows<Vec3f>("NORMAL");
    REQUIRE(normals.size() == 4);
    for (const Vec3f normal : normals)
        CHECK(length(normal) == Approx(1));
    CHECK(glb.primitive().at("attributes").size() == 2);
    CHECK_FALSE(glb.json.contains("extensionsUsed"));
}

TEST_CASE("indices take two bytes up to 65535 vertices, and four beyond")
{
    const auto type_of_index = [](std::uint32_t side)
    {
        const Mesh mesh = testing::rectangle({}, {1, 0, 0}, {0, 1, 0}, side, side);
        const Glb glb(exported_mesh(Value::Map{}, mesh).file);
        const auto& indices = glb.json.at("accessors").at(glb.primitive().at("indices").get<std::size_t>());
        CHECK(indices.at("count") == 6 * side * side);
        return indices.at("componentType").get<int>();
    };
    CHECK(type_of_index(254) == 5123);  // 255^2 = 65025 vertices
    CHECK(type_of_index(255) == 5125);  // 65536
}

TEST_CASE("a relief brings tangents and two pictures")
{
    const Relief relief = *even_relief(square().mesh, {0.3F, 0.6F, 0.9F});
    const testing::Inputs inputs{{"textured_mesh", std::make_shared<TexturedMesh>(square())},
                                 {"relief", std::make_shared<Relief>(relief)}};
    testing::TestRun run;
    const auto maps = texturing::tangent_maps(relief, square().mesh, 0, run);
    texturing::WeldedMesh welded = texturing::weld(square().mesh);
    texturing::add_tangents(welded);
    const Glb glb(exported_from(Value::Map{}, inputs).file);
    const auto& material = glb.json.at("materials").at(0);
    CHECK(material.at("normalTexture").at("index") == 1);
    CHECK(material.at("pbrMetallicRoughness").at("metallicRoughnessTexture").at("index") == 2);
    CHECK(holds_png(glb.picture(1), maps.normals));
    CHECK(holds_png(glb.picture(2), maps.roughness));
    CHECK(glb.rows<std::array<float, 4>>("TANGENT") == welded.tangents);
    CHECK(glb.rows<Vec3f>("NORMAL") == welded.normals);
    const Glb small(exported_from(Value::Map{{"max_texture_px", 4}}, inputs).file);
    CHECK(holds_png(small.picture(2), Raster8(4, 4, 1, 99)));
}

TEST_CASE("what cannot be exported is refused")
{
    const auto textured = std::make_shared<TexturedMesh>(square()), bare = std::make_shared<TexturedMesh>(square());
    bare->mesh.texcoords.clear();
    const auto mesh = std::make_shared<Mesh>(colored_square()), empty = std::make_shared<Mesh>();
    const auto relief = even_relief(square().mesh, {0, 0, 1}), other = even_relief(square().mesh, {0, 0, 1});
    other->atlas = "0123";
    const auto refused = [](const testing::Inputs& inputs, const char* why)
    { CHECK_THROWS_WITH(exported_from(Value::Map{}, inputs), Contains(why)); };
    refused({}, "wire 'textured_mesh' (a texture.bake stage), or 'mesh'");
    refused({{"textured_mesh", textured}, {"mesh", mesh}}, "both 'textured_mesh' and 'mesh' are wired");
    refused({{"textured_mesh", bare}}, "the mesh on port 'textured_mesh' has no texcoords");
    refused({{"mesh", empty}}, "the mesh on port 'mesh': the mesh has no faces");
    refused({{"textured_mesh", textured}, {"relief", other}}, "the relief on port 'relief'");
    refused({{"mesh", mesh}, {"relief", relief}}, "needs port 'textured_mesh'");
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.gltf"}}), Contains("ending in .glb"));
    CHECK(exported(Value::Map{{"path", "deep/er/a b.glb"}}).names.at(0) == "deep/er/a b.glb");
}
