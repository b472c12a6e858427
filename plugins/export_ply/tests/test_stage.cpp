#include "catch.h"
#include "stored_png.h"
#include "vertex_colors.h"

#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/texturing/texture_pictures.h>

using namespace fresco;
using namespace fresco::texturing;
using Catch::Contains;
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

TEST_CASE("faces count by their area on the surface, not in the atlas")
{
    TexturedMesh textured = half_picture(8);
    Mesh& mesh = textured.mesh;
    // A second face at vertex 0 with three times the area, over one texel of the other half.
    mesh.positions.insert(mesh.positions.end(), {{-3, 0, 0}, {0, -1, 0}});
    mesh.triangles.push_back({0, 3, 4});
    mesh.texcoords.insert(mesh.texcoords.end(), {{0.9F, 0.9F}, {0.95F, 0.9F}, {0.9F, 0.95F}});
    for (int c = 0; c < 3; ++c)
        textured.image.pixels.at(7, 0, c) = 255;
    testing::TestRun run;
    CHECK(to_linear(vertex_colors(textured, run)[0][0]) == Approx(0.75).margin(0.005));
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

struct Exported
{
    testing::TemporaryFolder folder;
    std::vector<std::string> names;
    testing::TestRun run;

    fs::path path(const std::string& name) const { return folder.path() / "files" / name; }
};

std::unique_ptr<Exported> exported(const Value& options, const TexturedMesh& textured = two_squares())
{
    auto result = std::make_unique<Exported>();
    Value all = options;
    if (!all.find("up"))
        all.set("up", "keep");
    testing::run_stage(FRESCO_PLUGIN_FILE, "export.ply", all, {{"textured_mesh", std::make_shared<TexturedMesh>(textured)}},
                       result->folder.path(), result->run, {{"image_io", std::make_shared<stored_png::Codec>()}});
    result->names = Files::load({result->folder.path() / "files", result->folder.path()})->names;
    return result;
}

std::string header_of(const fs::path& file)
{
    const auto bytes = read_file(file);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.substr(0, text.find("end_header\n"));
}

}  // namespace

TEST_CASE("the mesh is turned to stand with z up")
{
    const auto result = exported(Value::Map{{"up", "y"}, {"texcoords", "none"}});
    const Mesh mesh = two_squares().mesh;
    const Mesh read = read_mesh(result->path("room.ply"));
    REQUIRE(read.positions.size() == mesh.positions.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3f p = mesh.positions[v];
        CHECK(length(read.positions[v] - Vec3f{p.x, -p.z, p.y}) < 1e-6F);
    }
}

TEST_CASE("with texcoords at vertices the mesh is split along seams, and nowhere else")
{
    const auto result = exported(Value::Map{{"path", "a/wall.ply"}});
    CHECK(result->names == std::vector<std::string>{"a/wall.ply", "a/wall.png"});
    const std::string header = header_of(result->path("a/wall.ply"));
    CHECK_THAT(header, Contains("comment TextureFile wall.png\n") && Contains("property float s\nproperty float t\n"));
    CHECK_THAT(header, !Contains("red"));
    const Mesh read = read_mesh(result->path("a/wall.ply"));
    // Six places, of which the two on the seam are there twice.
    CHECK(read.positions.size() == 8);
    const Mesh meant = two_squares().mesh;
    REQUIRE(read.triangles.size() == 4);
    for (std::size_t corner = 0; corner < 12; ++corner)
    {
        CHECK(read.positions[read.triangles[corner / 3][corner % 3]] == meant.positions[meant.triangles[corner / 3][corner % 3]]);
        CHECK(read.texcoords[corner] == meant.texcoords[corner]);
    }
    CHECK(stored_png::Codec().read_rgb(result->path("a/wall.png")) == two_squares().image.pixels);
    REQUIRE(result->run.messages.size() == 2);
    CHECK_THAT(result->run.messages[0], Contains("a/wall.png: ") && Contains("8 x 8 texels, valid"));
    CHECK_THAT(result->run.messages[1], Contains("a/wall.ply: ") && Contains("5 triangles, 8 vertices, valid"));
}

TEST_CASE("with texcoords at faces the mesh keeps its vertices")
{
    const auto result = exported(Value::Map{{"texcoords", "face"}, {"max_texture_px", 4}});
    const std::string header = header_of(result->path("room.ply"));
    CHECK_THAT(header, Contains("comment TextureFile room.png\n") && Contains("property list uchar float texcoord\n"));
    const Mesh read = read_mesh(result->path("room.ply"));
    CHECK(read.positions == two_squares().mesh.positions);
    const Mesh meant = two_squares().mesh;
    CHECK(read.texcoords == std::vector<Vec2f>(meant.texcoords.begin(), meant.texcoords.begin() + 12));
    CHECK(stored_png::Codec().read_rgb(result->path("room.png")).width == 4);
}

TEST_CASE("vertex colors go with their vertices, split or not, and need no picture")
{
    TexturedMesh textured = two_squares();
    // The left square red, the right one blue.
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
        {
            const bool left = x < 3 && y > 4;
            const Rgb8 color = left ? Rgb8{250, 0, 0} : Rgb8{0, 0, 250};
            std::copy(color.begin(), color.end(), &textured.image.pixels.at(x, y, 0));
        }
    for (const std::string texcoords : {"vertex", "face", "none"})
    {
        const auto result = exported(Value::Map{{"texcoords", texcoords}, {"colors", true}}, textured);
        CHECK(result->names.size() == (texcoords == "none" ? 1 : 2));
        const Mesh read = read_mesh(result->path("room.ply"));
        REQUIRE(read.colors.size() == read.positions.size());
        CHECK(read.texcoords.empty() == (texcoords == "none"));
        for (std::size_t v = 0; v < read.positions.size(); ++v)
        {
            const float x = read.positions[v].x;
            if (x == 0)
                CHECK(read.colors[v] == Rgb8{250, 0, 0});
            else if (x == 2)
                CHECK(read.colors[v] == Rgb8{0, 0, 250});
            else
                CHECK((read.colors[v][0] > 100 && read.colors[v][2] > 100));
        }
    }
}

TEST_CASE("what cannot be exported is refused")
{
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "room.obj"}}), Contains("ending in .ply"));
    CHECK_THROWS_WITH(exported(Value::Map{{"path", "my room.ply"}}), Contains("no spaces"));
    TexturedMesh bare = two_squares();
    bare.mesh.texcoords.clear();
    CHECK_THROWS_WITH(exported(Value::Map{}, bare), Contains("no texcoords"));
}

TEST_CASE("a mesh without a picture is one file with its vertex colors, and with texcoords where it has them")
{
    Mesh mesh = two_squares().mesh;
    mesh.triangles.pop_back();
    mesh.texcoords.resize(12);
    mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}, {13, 14, 15}, {16, 17, 18}};
    for (const char* texcoords : {"vertex", "face", "none", ""})
    {
        Value options = Value::Map{{"texcoords", *texcoords == 0 ? "vertex" : texcoords}, {"up", "keep"}};
        if (*texcoords == 0)
            mesh.texcoords.clear();
        testing::TemporaryFolder folder;
        testing::TestRun run;
        testing::run_stage(FRESCO_PLUGIN_FILE, "export.ply", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, folder.path(),
                           run);
        CHECK(Files::load({folder.path() / "files", folder.path()})->names == std::vector<std::string>{"room.ply"});
        const Mesh read = read_mesh(folder.path() / "files/room.ply");
        CHECK(read.triangles.size() == 4);
        CHECK(read.texcoords.empty() == (*texcoords == 0 || std::string(texcoords) == "none"));
        // Split along the seam between the squares where vertices carry the texcoords.
        CHECK(read.positions.size() == (std::string(texcoords) == "vertex" ? 8 : 6));
        for (std::size_t corner = 0; corner < 12; ++corner)
        {
            const auto v = read.triangles[corner / 3][corner % 3];
            const auto w = mesh.triangles[corner / 3][corner % 3];
            CHECK(read.colors[v] == mesh.colors[w]);
            CHECK(read.positions[v] == mesh.positions[w]);
        }
        CHECK(header_of(folder.path() / "files/room.ply").find("TextureFile") == std::string::npos);
    }
}
