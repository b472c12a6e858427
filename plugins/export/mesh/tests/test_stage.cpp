#include "catch.h"
#include "exported_files.h"
#include "mesh_files.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/npy.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/texturing/texture_pictures.h>

#include <span>

using namespace fresco;
using namespace fresco::texturing;
using exported_files::Exported;
namespace fs = std::filesystem;

namespace
{

/// A right triangle over the lower left half of the picture.
TexturedMesh half_picture(int size)
{
    TexturedMesh textured;
    textured.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    textured.mesh.triangles = {{0, 1, 2}};
    textured.mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}};
    textured.image = Image(Raster8(size, size, 3));
    return textured;
}

}  // namespace

TEST_CASE("a vertex sees the texels of its faces by their nearness, in linear light")
{
    TexturedMesh textured = half_picture(64);
    // Light that rises with u: L = u. The mean of u over the triangle with weight lambda is 1/4 at corners with u = 0 and 1/2 at
    // the one with u = 1.
    textured.image.pixels = testing::picture(64, 64, [](int x, int, int) { return from_linear((x + 0.5) / 64); });
    testing::TestRun run;
    const auto colors = vertex_colors(textured, run);
    REQUIRE(colors.size() == 3);
    CHECK(to_linear(colors[0][0]) == Approx(0.25).margin(0.01));
    CHECK(to_linear(colors[1][1]) == Approx(0.5).margin(0.01));
    CHECK(to_linear(colors[2][2]) == Approx(0.25).margin(0.01));
}

TEST_CASE("faces without area give the texel at the corner, vertices without faces are gray")
{
    TexturedMesh textured = half_picture(4);
    textured.mesh.positions.assign(4, {1, 2, 3});
    textured.image.pixels.at(3, 3, 1) = 99;
    testing::TestRun run;
    const auto colors = vertex_colors(textured, run);
    CHECK(colors[0] == Rgb8{0, 0, 0});
    CHECK(colors[1] == Rgb8{0, 99, 0});
    CHECK(colors[3] == Rgb8{128, 128, 128});
    // A texcoord far outside is at the border that it is beyond.
    textured.mesh.texcoords[1].x = 1e30F;
    CHECK(vertex_colors(textured, run)[1] == Rgb8{0, 99, 0});
    run.cancel_after(1);
    CHECK_THROWS_AS(vertex_colors(textured, run), Canceled);
}

namespace
{

/// Two squares beside each other that lie apart in the atlas, and a face without area.
TexturedMesh two_squares()
{
    TexturedMesh textured;
    textured.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0.3F}};
    textured.mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {3, 3, 4}};
    const Vec2f a{0, 0}, b{0.25F, 0}, c{0.25F, 0.25F}, d{0, 0.25F};
    const Vec2f e{0.5F, 0.5F}, f{0.75F, 0.5F}, g{0.75F, 0.75F}, h{0.5F, 0.75F};
    textured.mesh.texcoords = {a, b, c, a, c, d, e, f, g, e, g, h, d, d, c};
    textured.image = Image(Raster8(8, 8, 3, 77));
    textured.image.pixels.at(1, 2, 0) = 200;
    return textured;
}

/// Its numbers are those that a short text loses.
Mesh odd_square()
{
    Mesh mesh;
    mesh.positions = {{0.1F, 1e-7F, -123456.79F}, {1, 0, 0}, {1, 1, -2}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.texcoords = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0.333333343F, 0.75F}};
    return mesh;
}

Exported exported_from(Value options, const testing::Inputs& inputs)
{
    if (!options.find("up"))
        options.set("up", "keep");
    return exported_files::exported_by("export.mesh", options, inputs);
}

Exported exported(const Value& options, const TexturedMesh& textured = two_squares())
{
    return exported_from(options, {{"textured_mesh", std::make_shared<TexturedMesh>(textured)}});
}

Exported exported_mesh(const Value& options, const Mesh& mesh)
{
    return exported_from(options, {{"mesh", std::make_shared<Mesh>(mesh)}});
}

/// The mesh holds the other one's faces, but for those without area, which readers drop: corner by corner, to the last bit.
void check_same_corners(const Mesh& found, const Mesh& meant)
{
    REQUIRE(found.triangles.size() <= meant.triangles.size());
    REQUIRE(found.texcoords.size() == (meant.texcoords.empty() ? 0 : 3 * found.triangles.size()));
    for (std::size_t corner = 0; corner < 3 * found.triangles.size(); ++corner)
    {
        const auto v = found.triangles[corner / 3][corner % 3];
        const auto w = meant.triangles[corner / 3][corner % 3];
        CHECK(found.positions[v] == meant.positions[w]);
        if (!meant.texcoords.empty())
            CHECK(found.texcoords[corner] == meant.texcoords[corner]);
        if (!meant.colors.empty())
            CHECK(found.colors.at(v) == meant.colors[w]);
    }
}

std::string header_of(const Exported& exported)
{
    return exported.file.substr(0, exported.file.find("end_header\n"));
}

}  // namespace

TEST_CASE("obj, mtl and png stand beside each other and name each other")
{
    TexturedMesh textured = two_squares();
    textured.mesh.colors.assign(6, {1, 2, 3});  // They do not disturb.
    const auto result = exported(Value::Map{{"path", "scene/kitchen.obj"}}, textured);
    CHECK(result.names == std::vector<std::string>{"scene/kitchen.obj", "scene/kitchen.mtl", "scene/kitchen.png"});
    const std::string& obj = result.file;
    CHECK(obj.starts_with("mtllib kitchen.mtl\n"));
    CHECK_THAT(obj, Contains("usemtl texture\n"));
    const std::string mtl = read_text_file(result.path("scene/kitchen.mtl"));
    CHECK_THAT(mtl, Contains("newmtl texture\n") && Contains("map_Kd kitchen.png\n"));
    CHECK(stored_png::Codec().read_rgb(result.path("scene/kitchen.png")) == textured.image.pixels);
    check_same_corners(read_mesh(result.path("scene/kitchen.obj")), two_squares().mesh);
    CHECK_THAT(obj, Contains("\nvt ") && !Contains("\nvt 0 0\nvt 0 0"));
}

TEST_CASE("a PLY is split along the atlas's seams, and nowhere else")
{
    const auto result = exported(Value::Map{{"path", "a/wall.ply"}});
    CHECK(result.names == std::vector<std::string>{"a/wall.ply", "a/wall.png"});
    const std::string header = header_of(result);
    CHECK_THAT(header, Contains("comment TextureFile wall.png\n") && Contains("property float s\nproperty float t\n"));
    CHECK_THAT(header, !Contains("red"));
    const Mesh read = read_mesh(result.path("a/wall.ply"));
    CHECK(read.positions.size() == 8);  // Six, of which the two on the seam are there twice.
    CHECK(read.triangles.size() == 4);
    check_same_corners(read, two_squares().mesh);
    CHECK(stored_png::Codec().read_rgb(result.path("a/wall.png")) == two_squares().image.pixels);
}

TEST_CASE("the mesh is turned to stand with y up in an OBJ, with z up in a PLY")
{
    const Mesh mesh = two_squares().mesh;
    const auto obj = exported(Value::Map{{"up", "z"}});
    const auto ply = exported(Value::Map{{"up", "y"}, {"path", "room.ply"}, {"colors", true}});
    const Mesh of_obj = read_mesh(obj.path("room.obj"));
    const Mesh of_ply = read_mesh(ply.path("room.ply"));
    REQUIRE(of_obj.positions.size() == mesh.positions.size());
    REQUIRE(of_ply.positions.size() == mesh.positions.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3f p = mesh.positions[v];
        CHECK(length(of_obj.positions[v] - Vec3f{p.x, p.z, -p.y}) < 1e-6F);
        CHECK(length(of_ply.positions[v] - Vec3f{p.x, -p.z, p.y}) < 1e-6F);
    }
}

TEST_CASE("colors at a PLY's vertices replace the picture")
{
    TexturedMesh textured = two_squares();
    // The left square red, the right one blue.
    textured.image.pixels = testing::picture(8, 8,
                                             [](int x, int y, int c)
                                             {
                                                 const bool left = x < 3 && y > 4;
                                                 return c == (left ? 0 : 2) ? 250 : 0;
                                             });
    const auto result = exported(Value::Map{{"path", "room.ply"}, {"colors", true}}, textured);
    CHECK(result.names == std::vector<std::string>{"room.ply"});
    const Mesh read = read_mesh(result.path("room.ply"));
    CHECK(read.positions == textured.mesh.positions);
    CHECK(read.texcoords.empty());
    REQUIRE(read.colors.size() == 6);
    for (std::size_t v = 0; v < 6; ++v)
    {
        const float x = read.positions[v].x;
        if (x == 1)
            CHECK((read.colors[v][0] > 100 && read.colors[v][2] > 100));
        else
            CHECK(read.colors[v] == (x == 0 ? Rgb8{250, 0, 0} : Rgb8{0, 0, 250}));
    }
}

TEST_CASE("a mesh without a picture is one file with vertex colors and texcoords, where it has them")
{
    Mesh mesh = odd_square();
    mesh.colors = {{0, 1, 2}, {30, 90, 188}, {254, 255, 253}, {7, 77, 177}};
    for (const bool with_texcoords : {true, false})
    {
        if (!with_texcoords)
            mesh.texcoords.clear();
        for (const std::string name : {"room.obj", "room.ply"})
        {
            const auto result = exported_mesh(Value::Map{{"path", name}}, mesh);
            CHECK(result.names == std::vector<std::string>{name});
            const Mesh read = read_mesh(result.path(name));
            CHECK(read.triangles.size() == 2);
            check_same_corners(read, mesh);
            CHECK_THAT(header_of(result), !Contains("TextureFile") && !Contains("mtllib"));
        }
    }
}

TEST_CASE("only the picture: PNG and NPY hold every texel, JPEG its size")
{
    CHECK(stored_png::Codec().read_rgb(exported(Value::Map{{"path", "room.png"}}).path("room.png")) ==
          two_squares().image.pixels);
    const auto npy = exported(Value::Map{{"path", "a/b.npy"}});
    CHECK(npy.names == std::vector<std::string>{"a/b.npy"});
    const NpyArray array = read_npy(npy.path("a/b.npy"));
    CHECK(array.shape == std::vector<std::size_t>{8, 8, 3});
    CHECK(std::ranges::equal(array.as<std::uint8_t>(), two_squares().image.pixels.values));
    const auto jpg = exported(Value::Map{{"path", "c.jpg"}, {"max_texture_px", 4}});
    CHECK(stored_png::Codec().read_rgb(jpg.path("c.jpg")).width == 4);
    CHECK(jpg.report.at("texture_px").as_int() == 4);
}

TEST_CASE("a scan far from 0 is written less its offset, or with its own coordinates")
{
    TexturedMesh textured = two_squares();
    textured.mesh.offset_m = {448'000, -5'411'000, 0};
    Mesh bare = textured.mesh;
    bare.texcoords.clear();
    bare.triangles.pop_back();
    for (const std::string name : {"room.obj", "room.ply"})
        for (const bool has_picture : {true, false})
        {
            INFO(name << has_picture);
            const auto written = [&](const Value& options)
            { return has_picture ? exported(options, textured) : exported_mesh(options, bare); };
            const auto original = written(Value::Map{{"path", name}, {"coordinates", "original"}, {"up", "auto"}});
            MeshReadReport report;
            const Mesh read = read_mesh(original.path(name), {}, &report);
            CHECK_THAT(original.file.substr(0, 400), !Contains("offset_m"));
            CHECK(read.offset_m == textured.mesh.offset_m);
            check_same_corners(read, has_picture ? textured.mesh : bare);
            CHECK(std::ranges::count(report.positions, Vec3d{448'002, -5'410'999, 0.3}) == 1);
            CHECK(original.report.find("offset_m") == nullptr);

            const auto local = written(Value::Map{{"path", name}});
            const Mesh near = read_mesh(local.path(name));
            CHECK(near.offset_m == (name == "room.obj" ? Vec3d{} : textured.mesh.offset_m));
            check_same_corners(near, has_picture ? textured.mesh : bare);
            CHECK(local.report.at("offset_m") == Value(Value::List{448'000.0, -5'411'000.0, 0.0}));
        }
    CHECK_THROWS_WITH(exported(Value::Map{{"coordinates", "original"}, {"up", "y"}}, textured), Contains("remove option \"up\""));
    // Turned, the offset is, too.
    const Value turned = exported(Value::Map{{"up", "z"}}, textured).report.at("offset_m");
    CHECK(turned.as_list().at(0).as_double() == Approx(448'000));
    CHECK(turned.as_list().at(1).as_double() == Approx(0).margin(1e-6));
    CHECK(turned.as_list().at(2).as_double() == Approx(5'411'000));
}

TEST_CASE("what cannot be exported is refused")
{
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.stl"}}), Contains("ending in .obj, .ply"));
    for (const char* path : {"my room.ply", "my room.obj"})
        CHECK_THROWS_WITH(exported(Value::Map{{"path", path}}), Contains("no spaces"));
    TexturedMesh bare = two_squares();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(exported(Value::Map{}, bare), Contains("no texcoords"));
    CHECK_THROWS_WITH(exported_mesh(Value::Map{{"path", "room.png"}}, odd_square()), Contains("wire 'textured_mesh'"));
}
