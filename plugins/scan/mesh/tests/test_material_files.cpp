#include "catch.h"
#include "file_model.h"
#include "mtl.h"
#include "world_mesh.h"

#include "model_samples.h"

#include <fresco/error.h>
#include <fresco/testing.h>

using namespace fresco;
using namespace model_samples;
using Catch::Contains;
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
    refused("newmtl a\nKd 1 1 2\n", "2: a color is outside 0 to 1");
    refused("newmtl a\nmap_Kd\n", "2: expected the name of a picture");
    refused("newmtl a\nmap_Kd -s x a.png\n", "2: expected a number after -s");
    refused("newmtl a\nmap_Kd -zoom 1 a.png\n", "2: unknown option \"-zoom\"");
}

TEST_CASE("what an OBJ names and what is missing is said with file and line", "[scan.mesh]")
{
    const Files files;
    CHECK_THROWS_WITH(files.obj(triangle + "mtllib no such.mtl\nf 1/1 2/2 3/3\n"),
                      Contains("a.obj:7: mtllib: \"no such.mtl\" is not in " + files.folder.path().string()) &&
                          Contains("set materials: skip"));
    CHECK_THROWS_AS(files.obj(triangle + "mtllib no.mtl\nf 1/1 2/2 3/3\n"), MissingInput);
    files.write("my room.mtl", "newmtl wall\nmap_Kd textures\\wall 1.png\n");
    const std::string wall = triangle + "mtllib my room.mtl\nusemtl wall\nf 1/1 2/2 3/3\n";
    CHECK_THROWS_WITH(files.obj(wall), Contains("my room.mtl:2: map_Kd: \"textures\\wall 1.png\" is not in"));
    CHECK_THROWS_WITH(files.obj(triangle + "mtllib my room.mtl\nusemtl floor\nf 1/1 2/2 3/3\n"),
                      Contains("a.obj:8: usemtl: no file that mtllib names has \"newmtl floor\""));
    std::filesystem::create_directories(files.folder.path() / "textures");
    files.picture("textures/wall 1.png");
    CHECK(files.obj(wall).pictures.at(0).file == files.folder.path() / "textures/wall 1.png");
    files.write("my room.mtl", "newmtl wall\nmap_Kd /etc/wall.png\n");
    CHECK_THROWS_WITH(files.obj(wall), Contains("my room.mtl:2: map_Kd: \"/etc/wall.png\" is outside the model's folder"));
    CHECK(read_file_model(files.folder.path() / "a.obj", false).materials.size() == 1);

    // Several libraries on one line; a material without a definition where no library is named.
    files.write("one.mtl", "newmtl wall\nKd 0 0 0\n");
    files.write("two.mtl", "newmtl floor\nKd 1 0.5 0\n");
    const auto two = files.obj(triangle + "mtllib one.mtl two.mtl\nusemtl floor\nf 1/1 2/2 3/3\n");
    CHECK(two.materials.at(0).color.y == Approx(0.2159).margin(1e-3));
    CHECK(files.obj(triangle + "usemtl floor\nf 1/1 2/2 3/3\n").materials.at(0).color == Vec3f{1, 1, 1});
    CHECK_THROWS_WITH(read_file_model(files.write("a.stl", "solid"), true), Contains("a .ply, .obj, .glb or .gltf file"));
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
    CHECK_THROWS_WITH(ply("comment TextureFile c.png\n", uv, vertices),
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
