#include "catch.h"
#include "file_model.h"
#include "mtl.h"
#include "world_mesh.h"

#include "model_samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>

using namespace fresco;
using namespace model_samples;
using scan_mesh::FileModel;
using scan_mesh::read_file_model;

namespace
{

const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

struct Files
{
    testing::TemporaryFolder folder;

    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        write_file(folder.path() / name, text);
        return folder.path() / name;
    }
    FileModel obj(const std::string& text) const { return read_file_model(write("a.obj", text), true); }
    void picture(const std::string& name) const
    {
        write_file(folder.path() / name, stored_png::Codec().encode_png(Raster8(1, 1, 3)));
    }
};

}  // namespace

TEST_CASE("MTL: colors, pictures and the options of map_Kd", "[scan.mesh]")
{
    const auto materials = scan_mesh::parse_mtl("# made\r\nnewmtl the wall\r\nKa 0 0 0\r\nKd 0.5 0.25 1\r\n\nnewmtl b\n\tKd 0.5\n"
                                                "map_Kd -s 2 3 1 -blendu on -o 0.5 -mm 0 1 -clamp on my picture.png  \n",
                                                "a.mtl");
    REQUIRE(materials.size() == 2);
    CHECK(materials[0].name == "the wall");
    CHECK(materials[0].color == std::array<double, 3>{0.5, 0.25, 1});
    CHECK(materials[0].picture.empty());
    CHECK(materials[1].color == std::array<double, 3>{0.5, 0.5, 0.5});
    CHECK(materials[1].picture == "my picture.png");
    CHECK(materials[1].picture_line == 8);
    CHECK(materials[1].scale == Vec2d{2, 3});
    CHECK(materials[1].offset == Vec2d{0.5, 0});
    CHECK(materials[1].clamp);
    const auto refused = [](const std::string& text, const std::string& message)
    { CHECK_THROWS_WITH(scan_mesh::parse_mtl(text, "a.mtl"), Contains("a.mtl:" + message)); };
    refused("Kd 1 1 1\n", "1: expected 'newmtl NAME'");
    refused("newmtl a\nKd 1 1\n", "2: expected 'Kd R G B'");
    refused("newmtl a\nKd 1 1 x\n", "2: expected 'Kd R G B'");
    refused("newmtl a\nmap_Kd\n", "2: expected the name of a picture");
    refused("newmtl a\nmap_Kd -s x a.png\n", "2: expected a number after -s");
    refused("newmtl a\nmap_Kd -zoom 1 a.png\n", "2: unknown option \"-zoom\"");
}

TEST_CASE("objects of an OBJ are its objects and the groups in them, whatever their materials", "[scan.mesh]")
{
    const Files files;
    const auto objects = [&](const std::string& text)
    {
        const FileModel model = files.obj(triangle + text);
        std::vector<std::string> names;
        for (const std::uint32_t object : model.object_of_face)
            names.push_back(object < model.objects.size() ? model.objects[object] : "");
        return names;
    };
    using Names = std::vector<std::string>;
    // A quad, a face without area and a continued line: the numbers of faces are those of the mesh.
    CHECK(objects("f 1 2 3\no  the chair \r\nusemtl wood\nf 1 2 3\nf 1 1 2\nusemtl o\nf 1 2 3 1\n\tg leg\nf 1 2 \\\n3\ng\nf 1 2 "
                  "3\no table\n"
                  "f 1 2 3\ng leg\nf 1 2 3\nusemtl iron\nf 1 2 3\no\nf 1 2 3\n") ==
          Names{"", "the chair", "the chair", "the chair/leg", "the chair", "table", "table/leg", "table/leg", ""});
    CHECK(objects("g Chair Back\nf 1 2 3\ng Chair Seat\nf 1 2 3\n") == Names{"Chair Back", "Chair Seat"});
    // One name for all says nothing.
    CHECK(objects("o scan\nf 1 2 3\n").empty());
    CHECK(scan_mesh::read_file_model(files.write("b.obj", triangle + "o a\nf 1 2 3\no b\nf 1 2 3\n"), false).objects ==
          Names{"a", "b"});
}

TEST_CASE("an OBJ without its materials or pictures keeps its shape and colors, with one warning each", "[scan.mesh]")
{
    const Files files;
    files.write("a.mtl",
                "newmtl red\nKd 1.0001 0 -0.001\nnewmtl wall\nKd 0 1 0\nmap_Kd textures\\wall 1.png\nnewmtl hot\nKd 2 1 1\n");
    const std::string named = triangle + "mtllib a.mtl\n";
    const std::string faces = "f 1/1 2/2 3/3\nf 3/3 2/2 1/1\n";
    struct Case
    {
        std::string text;
        Vec3f color;
        std::string warning;
    };
    const std::vector<Case> cases{
        {triangle + "mtllib no such.mtl\nusemtl red\nusemtl b\n",
         {1, 1, 1},
         "a.obj:7: mtllib: \"no such.mtl\" is not in FOLDER, nor with"},
        {triangle + "usemtl red\n", {1, 1, 1}, "a.obj:7: usemtl: no file that mtllib names has \"newmtl red\""},
        {named + "usemtl x\nusemtl y\nusemtl z\n",
         {1, 1, 1},
         "a.obj:8: usemtl: no file that mtllib names has \"newmtl x\", and 2 more"},
        {named + "usemtl wall\n",
         {0, 1, 0},
         "a.mtl:5: map_Kd: \"textures\\wall 1.png\" is not in FOLDER, nor with another case or by the last"},
    };
    for (auto [text, color, warning] : cases)
    {
        if (const auto at = warning.find("FOLDER"); at != std::string::npos)
            warning.replace(at, 6, files.folder.path().string());
        const auto model = files.obj(text + faces);
        CHECK(model.mesh.triangles.size() == 2);
        for (const std::uint32_t material : model.material_of_face)
            CHECK(model.materials.at(material).color == color);
        CHECK(model.pictures.empty());
        CHECK(!model.looked_for.empty() == (warning.find(" is not in ") != std::string::npos));
        REQUIRE(model.warnings.size() == (text.starts_with(named) ? 2 : 1));
        CHECK_THAT(model.warnings.back() + model.warnings.front(), Contains(warning));
        CHECK(read_file_model(files.folder.path() / "a.obj", false).materials.size() == 1);
    }
    const auto red = files.obj(named + "usemtl red\nf 1 2 3\n");
    CHECK(red.materials.at(0).color == Vec3f{1, 0, 0});
    CHECK_THAT(red.warnings.at(0), Contains("a.mtl: the color Kd 2 1 1 of \"hot\" is cut to 0 to 1"));
    CHECK_THROWS_WITH(read_file_model(files.write("a.stl", "solid"), true), Contains("a .ply, .obj, .glb or .gltf file"));
}

TEST_CASE("files that an OBJ names by other paths are found below its folder, and nowhere else", "[scan.mesh]")
{
    const Files files;
    const std::filesystem::path& folder = files.folder.path();
    for (const char* below : {"room/textures", "room/mtl", "outside"})
        std::filesystem::create_directories(folder / below);
    for (const char* picture : {"room/textures/wall 1.png", "outside/wall 2.png", "room/wall 3.png"})
        files.picture(picture);
    const auto read = [&](const std::string& library, const std::string& picture)
    {
        files.write("room/mtl/A.mtl", "newmtl b\nmap_Kd " + picture + "\n");
        return read_file_model(files.write("room/a.obj", triangle + "mtllib " + library + "\nusemtl b\nf 1/1 2/2 3/3\n"), true);
    };
    for (const char* name : {"../textures/wall 1.png", "..\\textures\\WALL 1.png", "C:\\me\\room\\Textures\\wall 1.png",
                             "/home/me/textures/wall 1.png", "file:///me/textures/wall 1.png", "textures/./wall 1.png"})
    {
        CAPTURE(name);
        const auto model = read("MTL\\a.mtl", name);
        REQUIRE(model.pictures.size() == 1);
        CHECK(std::filesystem::equivalent(model.pictures[0].file, folder / "room/textures/wall 1.png"));
        CHECK(model.warnings.empty());
        CHECK_THAT(model.messages.at(0), Contains("a.obj:7: mtllib: \"MTL\\a.mtl\" was found with another case: "));
        CHECK_THAT(model.messages.at(1), Contains("map_Kd: ") && Contains("was found by the last parts of their paths: "));
    }
    for (const std::string& name : {std::string("../../outside/wall 2.png"), (folder / "outside/wall 2.png").string()})
        CHECK_THAT(read("mtl/A.mtl", name).warnings.at(0), Contains("\"" + name + "\" is not in "));
    CHECK(read("C:\\x\\A.mtl", "wall 3.png").pictures.size() == 0);
    CHECK(read("mtl/A.mtl", "wall 3.png").pictures.size() == 1);
    std::filesystem::create_symlink(folder / "outside/wall 2.png", folder / "room/wall 2.png");
    CHECK_THROWS_WITH(read("mtl/A.mtl", "wall 2.png"), Contains("is a link to a file outside the model's folder"));
    files.picture("room/textures/Wall 1.png");
    CHECK_THROWS_WITH(read("mtl/A.mtl", "../textures/wALL 1.png"),
                      Contains("A.mtl:2: map_Kd: ") && Contains("two files could be meant"));

    // Several libraries on one line, of which one is missing.
    files.write("two.mtl", "newmtl floor\nKd 1 0.5 0\n");
    const auto two = files.obj(triangle + "mtllib one.mtl two.mtl\nusemtl floor\nf 1/1 2/2 3/3\n");
    CHECK(two.materials.at(0).color.y == Approx(0.2159).margin(1e-3));
    CHECK_THAT(two.warnings.at(0), Contains("a.obj:7: mtllib: \"one.mtl\" is not in "));
}

TEST_CASE("the UDIM tiles of a picture are read by the texcoords of faces", "[scan.mesh]")
{
    const Files files;
    files.picture("t.1001.png");
    const auto read = [&](const std::string& picture)
    {
        files.write("a.mtl", "newmtl a\nKd 0 0 1\nmap_Kd " + picture + "\n");
        return files.obj(
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 2 1\nvt 3 1\nvt 2 2\nvt -1 0\nvt -2 0\n"
            "usemtl a\nf 1/1 2/2 3/3\nf 1/4 2/5 3/6\nf 1/3 2/1 3/7\n");
    };
    const auto repeated = read("t.1001.png");
    CHECK(repeated.materials.size() == 1);
    CHECK(repeated.materials[0].wrap_u == Wrap::repeat);
    CHECK(repeated.mesh.texcoords[4] == Vec2f{3, 1});
    files.picture("t.1013.png");
    for (const char* name : {"t.1001.png", "t.<UDIM>.png"})
    {
        const auto tiled = read(name);
        REQUIRE(tiled.materials.size() == 3);
        CHECK(tiled.pictures.at(1).file.filename() == "t.1013.png");
        CHECK(tiled.materials[1].picture == 1);
        CHECK(tiled.materials[1].wrap_v == Wrap::clamp);
        CHECK(tiled.mesh.texcoords[4] == Vec2f{1, 0});
        CHECK(tiled.materials[2].picture == ModelMaterial::no_picture);
        CHECK(tiled.materials[2].color == Vec3f{0, 0, 1});
        CHECK_THAT(tiled.warnings.at(0), Contains("1 faces lie outside the UDIM tiles 1001 to 2000"));
    }
    files.picture("t.1002.png");
    std::filesystem::remove(files.folder.path() / "t.1013.png");
    const auto missing = read("t.1001.png");
    CHECK(missing.materials.at(1).color == Vec3f{0, 0, 1});
    CHECK_THAT(missing.warnings.at(0), Contains("map_Kd: \"t.1013.png\" is not in "));
    files.picture("t.21001.png");
    files.picture("t.21002.png");
    CHECK(read("t.21001.png").materials.size() == 1);
    // Numbered pictures of several materials are no tiles.
    CHECK(read("t.1001.png\nnewmtl b\nmap_Kd t.1002.png").materials.at(0).wrap_u == Wrap::repeat);
}

TEST_CASE("names of files may have a colon; too long ones and lists of them are refused, not looked for", "[scan.mesh]")
{
    const Files files;
    files.picture("hero:body.png");
    files.write("a.mtl", "newmtl a\nmap_Kd hero:body.png\n");
    CHECK(files.obj(triangle + "mtllib a.mtl\nusemtl a\nf 1/1 2/2 3/3\n").pictures.at(0).file.filename() == "hero:body.png");
    std::string deep;
    for (int i = 0; i < 70; ++i)
        deep += "a/";
    for (const std::string& name : {deep + "a.mtl", std::string(2000, 'a')})
        CHECK_THROWS_WITH(files.obj(triangle + "mtllib " + name + "\nf 1 2 3\n"), Contains("is not a file name"));
}

TEST_CASE("map_Kd places the texcoords of its faces; faces without take the color", "[scan.mesh]")
{
    const Files files;
    files.picture("a.png");
    files.write("a.mtl", "newmtl a\nKd 0 1 0\nmap_Kd -s 2 1 -o 0 0.5 -clamp on a.png\nnewmtl b\nmap_Kd a.png\n");
    const auto model = files.obj(triangle + "mtllib a.mtl\nusemtl a\nf 1/1 2/2 3/3\nf 1 2 3\nusemtl b\nf 1/1 2/2 3/3\n");
    REQUIRE(model.materials.size() == 3);
    CHECK(model.pictures.size() == 1);
    CHECK(model.materials[0].wrap_v == Wrap::clamp);
    CHECK(model.materials[1].picture == ModelMaterial::no_picture);
    CHECK(model.materials[1].color == Vec3f{0, 1, 0});
    CHECK(model.materials[2].wrap_v == Wrap::repeat);
    CHECK(model.mesh.texcoords[1] == Vec2f{2, 0.5F});
    CHECK(model.mesh.texcoords[7] == Vec2f{1, 0});
    CHECK(read_file_model(files.folder.path() / "a.obj", false).mesh.triangles.size() == 3);
    CHECK_THAT(model.warnings.at(0), Contains("1 faces have a picture but no texture coordinates"));
}

TEST_CASE("a PLY without texcoords, or with more pictures than it chooses from, is read with a warning", "[scan.mesh]")
{
    const Files files;
    files.picture("a.png");
    const std::string end = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nEXTRAelement face 1\n"
                            "property list uchar int vertex_indices\nend_header\n";
    const auto ply = [&](const std::string& pictures, const std::string& extra, const std::string& body)
    {
        std::string rest = end;
        rest.replace(rest.find("EXTRA"), 5, extra);
        return read_file_model(files.write("a.ply", "ply\nformat ascii 1.0\n" + pictures + rest + body + "3 0 1 2\n"), true);
    };
    const auto bare = ply("comment TextureFile a.png\n", "", "0 0 0\n1 0 0\n0 1 0\n");
    CHECK(bare.materials.at(0).picture == ModelMaterial::no_picture);
    CHECK_THAT(bare.warnings.at(0), Contains("the picture is not used"));
    const std::string uv = "property float s\nproperty float t\n";
    const std::string vertices = "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n";
    const auto two = ply("comment TextureFile a.png\ncomment TextureFile b.png\n", uv, vertices);
    CHECK(two.materials.at(0).picture == 0);
    CHECK_THAT(two.warnings.at(0), Contains("2 pictures but has no face property texnumber"));
    CHECK_THAT(ply("comment TextureFile c.png\n", uv, vertices).warnings.at(0),
               Contains("a.ply:3: comment TextureFile: \"c.png\" is not in"));
    const auto colored =
        ply("", "property uchar red\nproperty uchar green\nproperty uchar blue\n", "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n");
    CHECK(colored.materials.at(0).vertex_colors);
}

TEST_CASE("split vertices are joined, but not the two sides of a wall, nor other colors", "[scan.mesh]")
{
    // Two triangles of a square, each with its own corners, and the square's back.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, -0.0F, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 1, 0}, {1, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
    Mesh joined = mesh;
    CHECK(scan_mesh::join_vertices(joined) == 2);
    CHECK(joined.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {4, 5, 6}});
    CHECK(joined.positions[3] == Vec3f{0, 1, 0});
    joined = mesh;
    joined.colors.assign(9, Rgb8{1, 1, 1});
    joined.colors[3] = {2, 2, 2};
    CHECK(scan_mesh::join_vertices(joined) == 1);
    CHECK(joined.colors.size() == 8);
    CHECK(joined.triangles[1][0] != joined.triangles[0][0]);
}
