#include "catch.h"
#include "stored_png.h"
#include "usdz.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/relief.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>

#include <memory>

using namespace fresco;
using Catch::Contains;

namespace
{
using Contents = std::vector<std::pair<std::string, std::string>>;

std::string packed(const Contents& contents)
{
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "a.usdz";
    ZipWriter zip(file);
    for (const auto& [name, data] : contents)
    {
        zip.begin(name);
        for (std::size_t at = 0; at < data.size(); at += 7)
            zip.write(std::string_view(data).substr(at, 7));
    }
    zip.finish();
    return read_text_file(file);
}
}  // namespace

TEST_CASE("every file of a package begins at a multiple of 64 bytes, whatever the lengths of names and data")
{
    Contents contents;
    for (std::size_t length = 0; length < 140; ++length)
        contents.emplace_back("n" + std::string(length, 'x'), std::string(length * 3 % 200, static_cast<char>(length)));
    const std::string package = packed(contents);
    const std::vector<UsdzEntry> entries = read_usdz(package, "a.usdz");
    REQUIRE(entries.size() == contents.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
    {
        CHECK(entries[i].name == contents[i].first);
        CHECK(entries[i].data == contents[i].second);
        CHECK(static_cast<std::size_t>(entries[i].data.data() - package.data()) % 64 == 0);
    }
}

TEST_CASE("a package that was changed or cut is refused")
{
    const std::string package = packed({{"room.usda", "text"}, {"picture.png", std::string(100, 'p')}});
    const std::vector<UsdzEntry> entries = read_usdz(package, "a.usdz");
    for (std::size_t length = 0; length < package.size(); ++length)
        CHECK_THROWS_WITH(read_usdz(package.substr(0, length), "a.usdz"), Contains("a.usdz: "));
    CHECK_THROWS_AS(read_usdz(package + "x", "a.usdz"), Error);
    std::size_t unnoticed = 0;
    for (std::size_t at = 0; at < package.size(); ++at)
    {
        std::string changed = package;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        try
        {
            if (read_usdz(changed, "a.usdz").at(1).data == entries[1].data)
                ++unnoticed;
        }
        catch (const Error&)
        {
            continue;
        }
    }
    // Padding, and in the directory and its end the versions, attributes, numbers of disks and comments.
    const std::size_t padding = 64 - 30 - 9 - 2 + 192 - (64 + 4 + 30 + 11) - 2;
    CHECK(unnoticed <= padding + 2 * (2 + 12) + 6);
}

TEST_CASE("a full disk is an error that names the file")
{
    CHECK_THROWS_WITH(ZipWriter("/gone/a.usdz"), Contains("/gone/a.usdz: cannot be written: "));
    if (!std::filesystem::exists("/dev/full"))
        return;
    const auto fill = []
    {
        ZipWriter zip("/dev/full");
        zip.begin("a");
        zip.write(std::string(1 << 20, 'a'));
        zip.finish();
    };
    CHECK_THROWS_WITH(fill(), Contains("No space left on device"));
}

namespace
{
/// A square of two meters that lies a meter above the ground, and has a seam along its diagonal.
TexturedMesh square()
{
    TexturedMesh textured;
    textured.mesh.positions = {{1, 1, 0.1F}, {3, 1, 0}, {3, 1, -2}, {1, 1, -2}};
    textured.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 0.5F}, {1, 1}, {0, 0.75F}};
    textured.image = Image(Raster8(8, 8, 3, 77));
    textured.image.pixels.at(2, 1, 0) = 200;
    return textured;
}

struct Exported
{
    std::string package;
    std::vector<UsdzEntry> entries;
    Value report;
    std::vector<std::string> messages;
    std::string layer() const { return std::string(entries.at(0).data); }
};

Exported exported(const Value& options, const TexturedMesh& textured = square(), testing::Inputs more = {})
{
    more["textured_mesh"] = std::make_shared<TexturedMesh>(textured);
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    testing::run_stage(FRESCO_PLUGIN_FILE, "export.usdz", options, more, folder.path(), run,
                       {{"image_io", std::make_shared<stored_png::Codec>()}});
    const auto files = Files::load({folder.path() / "files", folder.path()});
    Exported result{read_text_file(folder.path() / "files" / files->names.at(0)), {}, run.reported, run.messages};
    result.entries = read_usdz(result.package, files->names.at(0));
    return result;
}
}  // namespace

TEST_CASE("the package holds a layer with the mesh, and then the picture")
{
    const Exported result = exported(Value::Map{{"up", "keep"}});
    REQUIRE(result.entries.size() == 2);
    CHECK(result.entries[0].name == "room.usda");
    CHECK(result.entries[1].name == "picture.png");
    const testing::TemporaryFolder folder;
    write_file(folder.path() / "picture.png", std::as_bytes(std::span(result.entries[1].data)));
    CHECK(stored_png::Codec().read_rgb(folder.path() / "picture.png") == square().image.pixels);

    const std::string layer = result.layer();
    CHECK_THAT(layer,
               Catch::StartsWith("#usda 1.0\n(\n    defaultPrim = \"room\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n"));
    CHECK_THAT(layer, Contains("double3 xformOp:translate = (-2, -1, 0.95)"));
    CHECK_THAT(layer, Contains("float3[] extent = [(1, 1, -2), (3, 1, 0.1)]"));
    CHECK_THAT(layer, Contains("int[] faceVertexCounts = [3, 3]"));
    CHECK_THAT(layer, Contains("int[] faceVertexIndices = [0, 1, 2, 3, 2, 4]"));
    CHECK_THAT(layer, Contains("point3f[] points = [(1, 1, 0.1), (3, 1, 0), (3, 1, -2), (1, 1, 0.1), (1, 1, -2)]"));
    CHECK_THAT(layer, Contains("texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 0.5), (0, 0.75)]"));
    CHECK_THAT(layer, Contains("uniform bool doubleSided = 1"));
    CHECK_THAT(layer, Contains("asset inputs:file = @picture.png@"));
    CHECK_THAT(layer, Contains("inputs:emissiveColor.connect") && Contains("inputs:diffuseColor = (0, 0, 0)"));
    CHECK_THAT(layer, !Contains("normals"));
    CHECK(result.report.at("triangles") == Value(2));
    CHECK(result.report.at("vertices") == Value(5));
    CHECK(result.report.at("bytes") == Value(result.package.size()));
    CHECK_THAT(result.messages.back(), Contains("room.usdz: ") && Contains("2 triangles") && Contains(", valid"));
}

TEST_CASE("a relief adds a normal map and the roughness")
{
    const auto relief = std::make_shared<Relief>();
    relief->atlas = atlas_id(square().mesh);
    relief->normals = Raster16(8, 8, 3);
    relief->roughness = Raster8(8, 8, 1, 99);
    for (std::size_t texel = 0; texel < 64; ++texel)
        relief->set_normal(texel, normalized(Vec3f{0.3F, 0.9F, 0.2F}));
    const Exported result = exported(Value::Map{}, square(), {{"relief", relief}});
    REQUIRE(result.entries.size() == 4);
    const auto holds = [&](std::size_t entry, const std::string& name, const Raster8& picture)
    {
        CHECK(result.entries[entry].name == name);
        CHECK(std::ranges::equal(std::as_bytes(std::span(result.entries[entry].data)), stored_png::Codec().encode_png(picture)));
    };
    testing::TestRun run;
    holds(2, "normals.png", texturing::tangent_maps(*relief, square().mesh, 0, run).normals);
    holds(3, "roughness.png", relief->roughness);
    CHECK_THAT(result.layer(), Contains("normal3f inputs:normal.connect = </room/material/normals.outputs:rgb>") &&
                                   Contains("float inputs:roughness.connect = </room/material/roughness.outputs:r>") &&
                                   Contains("inputs:scale = (2, 2, 2, 1)") && Contains("inputs:bias = (-1, -1, -1, 0)") &&
                                   Contains("@normals.png@") && Contains("@roughness.png@") && !Contains("roughness = 1"));
}

TEST_CASE("a lit room has normals, and its picture is what is lit")
{
    const std::string layer = exported(Value::Map{{"up", "y"}, {"material", "pbr"}}).layer();
    CHECK_THAT(layer, Contains("normal3f[] normals = [("));
    CHECK_THAT(layer, Contains("inputs:diffuseColor.connect") && !Contains("emissive"));
}

TEST_CASE("the room stands upright, with the middle of its floor at the origin")
{
    const Exported result = exported(Value::Map{{"up", "z"}, {"path", "a/b.usdz"}});
    CHECK_THAT(result.layer(), Contains("points = [(1, 0.1, -1), (3, ") && Contains(", (3, -2, -1)"));
    CHECK_THAT(result.layer(), Contains("xformOp:translate = (-2, 2, 1)"));
    CHECK(result.report.at("up") == Value(Value::List{0.0, 0.0, 1.0}));
}

TEST_CASE("many values are broken into lines and read back; a layer of another mesh is refused")
{
    TexturedMesh many = square();
    for (std::uint32_t i = 0; i < 100; ++i)
    {
        const auto at = static_cast<float>(i);
        const auto first = static_cast<std::uint32_t>(many.mesh.positions.size());
        many.mesh.positions.insert(many.mesh.positions.end(), {{at / 7, 0, 1}, {1e-7F * at, -1 / 3.0F, 2}, {-0.0F, at, 3}});
        many.mesh.triangles.push_back({first, first + 1, first + 2});
        many.mesh.texcoords.insert(many.mesh.texcoords.end(), {{0, 0}, {at / 100, 0.1F}, {1, 1}});
    }
    const Exported result = exported(Value::Map{{"up", "keep"}}, many);
    CHECK_THAT(result.layer(), Contains(",\n"));
    texturing::WeldedMesh mesh = texturing::weld(many.mesh);
    check_usda(result.layer(), mesh);
    const auto refused = [&](const texturing::WeldedMesh& other, const char* what)
    { CHECK_THROWS_WITH(check_usda(result.layer(), other), Contains(what)); };
    texturing::WeldedMesh other = mesh;
    other.positions[9].z = std::nextafter(other.positions[9].z, 9.0F);
    refused(other, "points, 9");
    other = mesh;
    other.texcoords[3].x += 0.5F;
    refused(other, "primvars:st, 3");
    other = mesh;
    std::swap(other.indices[6], other.indices[7]);
    refused(other, "faceVertexIndices, 6");
    other = mesh;
    other.positions.pop_back();
    refused(other, "more than the");
}

TEST_CASE("what cannot be exported is refused")
{
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.glb"}}), Contains("ending in .usdz"));
    TexturedMesh bare = square();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(exported(Value::Map{}, bare), Contains("texcoords"));
}
