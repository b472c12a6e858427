#include "exported_glb.h"
#include "read_glb.h"

using namespace fresco;
using Catch::Contains;

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

TEST_CASE("a mesh without a picture keeps its vertex colors to the step, in every form")
{
    for (const bool quantize : {false, true})
        for (const char* compression : {"none", "meshopt"})
        {
            const auto result = exported_mesh(Value::Map{{"quantize", quantize}, {"compression", compression}}, colored_square());
            const GlbModel model = read_glb(result.file, "a.glb");
            REQUIRE(model.colors.size() == model.positions.size());
            for (std::size_t v = 0; v < model.positions.size(); ++v)
            {
                const auto near = [&](Vec3f p) { return length(model.positions[v] - vec_cast<double>(p)) < 1e-4; };
                const Mesh mesh = colored_square();
                const auto found = std::ranges::find_if(mesh.positions, near);
                REQUIRE(found != mesh.positions.end());
                CHECK(model.colors[v] == mesh.colors[static_cast<std::size_t>(found - mesh.positions.begin())]);
            }
            CHECK(model.image.empty());
            CHECK(model.texcoords.size() == model.positions.size());
            CHECK(model.normals.empty());
            CHECK_THAT(result.messages.back(), Contains("3 triangles, valid"));
        }
    const Glb glb(exported_mesh(Value::Map{}, colored_square()).file);
    CHECK(glb.json.at("materials").at(0).at("extensions").contains("KHR_materials_unlit"));
    CHECK_FALSE(glb.json.contains("images"));
    CHECK_FALSE(glb.json.contains("textures"));
}

TEST_CASE("a mesh without any color is lit, so that its shape shows")
{
    Mesh mesh = square().mesh;
    mesh.texcoords.clear();
    const Exported result = exported_mesh(Value::Map{}, mesh);
    const GlbModel model = read_glb(result.file, "a.glb");
    CHECK(model.positions.size() == 4);
    CHECK(model.normals.size() == 4);
    CHECK(model.texcoords.empty());
    CHECK(model.colors.empty());
    CHECK_FALSE(Glb(result.file).json.contains("extensionsUsed"));
}

TEST_CASE("colors of a mesh with a picture stay out of the file: they would darken it")
{
    TexturedMesh textured = square();
    textured.mesh.colors = colored_square().colors;
    CHECK(read_glb(exported(Value::Map{}, textured).file, "a.glb").colors.empty());
}

TEST_CASE("one of the two ports is wired")
{
    const auto textured = std::make_shared<TexturedMesh>(square());
    const auto mesh = std::make_shared<Mesh>(colored_square());
    CHECK_THROWS_WITH(exported_from(Value::Map{}, {}), Contains("wire 'textured_mesh' (a texture.bake stage), or 'mesh'"));
    CHECK_THROWS_WITH(exported_from(Value::Map{}, {{"textured_mesh", textured}, {"mesh", mesh}}),
                      Contains("both 'textured_mesh' and 'mesh' are wired"));
    Mesh empty;
    CHECK_THROWS_WITH(exported_mesh(Value::Map{}, empty), Contains("the mesh on port 'mesh': the mesh has no faces"));
}
