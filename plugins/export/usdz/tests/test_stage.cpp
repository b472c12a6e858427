#include "catch.h"
#include "exported_files.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/relief.h>
#include <fresco/testing.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>
#include <fresco/zip.h>

#include <memory>

using namespace fresco;

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

struct Exported : exported_files::Exported
{
    std::string file(const std::string& name) const
    {
        const auto bytes = zip().contents(name);
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    ZipReader zip() const { return {std::as_bytes(std::span(exported_files::Exported::file)), "a.usdz"}; }
    std::string layer() const { return file("room.usda"); }
};

Exported exported(const Value& options, const TexturedMesh& textured = square(), testing::Inputs more = {})
{
    more["textured_mesh"] = std::make_shared<TexturedMesh>(textured);
    return {exported_files::exported_by("export.usdz", options, more)};
}

}  // namespace

TEST_CASE("the package holds a layer with the mesh, and then the picture")
{
    const Exported result = exported(Value::Map{{"up", "keep"}});
    CHECK(result.zip().names() == std::vector<std::string>{"picture.png", "room.usda"});
    // The first file is the one that is opened.
    CHECK(result.exported_files::Exported::file.find("room.usda") == 30);
    CHECK(exported_files::holds_png(result.file("picture.png"), square().image.pixels));
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
    CHECK(result.report.at("vertices") == Value(5));
}

TEST_CASE("a relief adds a normal map and the roughness")
{
    const auto relief = exported_files::even_relief(square().mesh, {0.3F, 0.9F, 0.2F});
    const Exported result = exported(Value::Map{}, square(), {{"relief", relief}});
    CHECK(result.zip().names().size() == 4);
    testing::TestRun run;
    CHECK(exported_files::holds_png(result.file("normals.png"), texturing::tangent_maps(*relief, square().mesh, 0, run).normals));
    CHECK(exported_files::holds_png(result.file("roughness.png"), relief->roughness));
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

TEST_CASE("many values are broken into lines, and have all their digits")
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
    const std::string layer = exported(Value::Map{{"up", "keep"}}, many).layer();
    CHECK_THAT(layer, Contains(",\n") && Contains("304]") && Contains("(14.142858, 0, 1)") && Contains(", -0.33333334, 2)") &&
                          Contains("(-0, 99, 3)]"));
}

TEST_CASE("what cannot be exported is refused")
{
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.glb"}}), Contains("ending in .usdz"));
    TexturedMesh bare = square();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(exported(Value::Map{}, bare), Contains("texcoords"));
}
