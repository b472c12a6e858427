#include "catch.h"
#include "obj_text.h"
#include "stored_png.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <span>

using namespace fresco;

namespace
{
TexturedMesh square()
{
    TexturedMesh textured;
    textured.mesh.positions = {{0.1F, 1e-7F, -123456.79F}, {1, 0, 0}, {1, 1, -2}, {0, 1, 0}};
    textured.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0.333333343F, 0.75F}};
    textured.image = Image(Raster8(4, 4, 3, 77));
    return textured;
}

std::vector<std::string> export_to(const std::filesystem::path& folder, const Value& options,
                                   const TexturedMesh& textured = square())
{
    testing::TestRun run;
    testing::run_stage(FRESCO_PLUGIN_FILE, "export.obj", options, {{"textured_mesh", std::make_shared<TexturedMesh>(textured)}},
                       folder, run, {{"image_io", std::make_shared<stored_png::Codec>()}});
    return run.messages;
}
}  // namespace

TEST_CASE("the strict reader gives the same mesh back, bit by bit")
{
    const Mesh mesh = square().mesh;
    const std::string text = obj_text(mesh, "a.mtl", "m");
    const Mesh read = parse_obj(std::as_bytes(std::span(text)), "test");
    CHECK(read.positions == mesh.positions);
    CHECK(read.triangles == mesh.triangles);
    CHECK(read.texcoords == mesh.texcoords);
    std::size_t texcoord_lines = 0;
    for (std::size_t at = text.find("\nvt "); at != std::string::npos; at = text.find("\nvt ", at + 1))
        ++texcoord_lines;
    CHECK(texcoord_lines == 4);  // of six corners
}

TEST_CASE("obj, mtl and png stand beside each other and name each other")
{
    testing::TemporaryFolder folder;
    const auto messages = export_to(folder.path(), Value::Map{{"path", "scene/kitchen.obj"}});
    REQUIRE(messages.size() == 3);
    CHECK_THAT(messages[1], Catch::Contains("scene/kitchen.png: ") && Catch::Contains("4 x 4 texels, valid"));
    CHECK_THAT(messages[2], Catch::Contains("scene/kitchen.obj: ") && Catch::Contains("2 triangles, valid"));
    const auto files = Files::load({folder.path() / "files", folder.path()});
    CHECK(files->names == std::vector<std::string>{"scene/kitchen.obj", "scene/kitchen.mtl", "scene/kitchen.png"});
    const auto base = folder.path() / "files" / "scene";
    CHECK(read_text_file(base / "kitchen.obj").starts_with("mtllib kitchen.mtl\n"));
    CHECK(read_text_file(base / "kitchen.obj").find("usemtl texture\n") != std::string::npos);
    CHECK(read_text_file(base / "kitchen.mtl").find("newmtl texture\n") != std::string::npos);
    CHECK(read_text_file(base / "kitchen.mtl").find("map_Kd kitchen.png\n") != std::string::npos);
    const stored_png::Codec codec;
    CHECK(read_file(base / "kitchen.png") == codec.encode_png(square().image.pixels));
}

TEST_CASE("the picture can be made smaller, and colors that the mesh has do not disturb")
{
    testing::TemporaryFolder folder;
    TexturedMesh textured = square();
    textured.mesh.colors.assign(4, {1, 2, 3});
    export_to(folder.path(), Value::Map{{"max_texture_px", 2}}, textured);
    CHECK(stored_png::Codec().read_rgb(folder.path() / "files/room.png").width == 2);
}

TEST_CASE("what cannot be exported is refused")
{
    testing::TemporaryFolder folder;
    CHECK_THROWS_WITH(export_to(folder.path(), Value::Map{{"path", "my room.obj"}}), Catch::Contains("no spaces"));
    CHECK_THROWS_WITH(export_to(folder.path(), Value::Map{{"path", "room.ply"}}), Catch::Contains(".obj"));
    TexturedMesh bare = square();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(export_to(folder.path(), Value::Map{}, bare), Catch::Contains("no texcoords"));
}

TEST_CASE("a mesh without a picture is one file with vertex colors and texcoords, where it has them")
{
    testing::TemporaryFolder folder;
    testing::TestRun run;
    Mesh mesh = square().mesh;
    mesh.colors = {{0, 1, 2}, {30, 90, 188}, {254, 255, 253}, {7, 77, 177}};
    for (const bool with_texcoords : {true, false})
    {
        if (!with_texcoords)
            mesh.texcoords.clear();
        testing::run_stage(FRESCO_PLUGIN_FILE, "export.obj", Value::Map{{"up", "keep"}}, {{"mesh", std::make_shared<Mesh>(mesh)}},
                           folder.path(), run);
        CHECK(Files::load({folder.path() / "files", folder.path()})->names == std::vector<std::string>{"room.obj"});
        const Mesh read = read_mesh(folder.path() / "files/room.obj");
        CHECK(read.positions == mesh.positions);
        CHECK(read.colors == mesh.colors);
        CHECK(read.texcoords == mesh.texcoords);
        CHECK_FALSE(read_text_file(folder.path() / "files/room.obj").starts_with("mtllib"));
    }
}

TEST_CASE("the mesh is turned to stand with y up")
{
    testing::TemporaryFolder folder;
    export_to(folder.path(), Value::Map{{"up", "z"}});
    const Mesh mesh = square().mesh;
    const Mesh read = read_mesh(folder.path() / "files/room.obj");
    REQUIRE(read.positions.size() == mesh.positions.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3f p = mesh.positions[v];
        CHECK(length(read.positions[v] - Vec3f{p.x, p.z, -p.y}) < 0.01F);
    }
    CHECK(read.texcoords == mesh.texcoords);
}
