#include "cut_bytes.h"
#include "ply_samples.h"

#include <fresco/error.h>
#include <fresco/mesh.h>

using namespace fresco;

namespace
{

Mesh parse(const std::string& text)
{
    return parse_obj(bytes_of(text), "room.obj");
}

const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string uvs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
const std::string normals = "vn 0 0 1\nvn 0 0 -1\n";

}  // namespace

TEST_CASE("OBJ: all index forms", "[obj]")
{
    const std::vector<Triangle> expected{{0, 2, 3}};
    const std::vector<Vec2f> corners{{1, 1}, {0, 0}, {0, 1}};
    const auto all = square + uvs + normals;
    for (const char* face : {"f 1 3 4\n", "f 1//1 3//2 4//1\n", "f -4 -2 -1\n", "f -4//-2 -2//-1 -1//2\n"})
    {
        const Mesh mesh = parse(all + face);
        CHECK(mesh.triangles == expected);
        CHECK(mesh.texcoords.empty());
    }
    for (const char* face : {"f 1/3 3/1 4/4\n", "f 1/3/1 3/1/1 4/4/2\n", "f -4/-2 -2/-4 -1/-1\n", "f 1/-2/-1 -2/1/1 4/-1/-2\n"})
    {
        const Mesh mesh = parse(all + face);
        CHECK(mesh.triangles == expected);
        CHECK(mesh.texcoords == corners);
    }
    // They count back from where they stand, and a face may come before its vertices.
    CHECK(parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -2 -1\n").triangles ==
          std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
    CHECK(parse("f 1/1 2/2 3/3\n" + square + uvs).texcoords == std::vector<Vec2f>{{0, 0}, {1, 0}, {1, 1}});
}

TEST_CASE("OBJ: colors, weights, comments, groups, line ends and continued lines", "[obj]")
{
    const Mesh colored = parse("v 0 0 0 0 0.5 1\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0.002\nf 1 2 3\n");
    CHECK(colored.colors == std::vector<Rgb8>{{0, 128, 255}, {255, 255, 255}, {0, 0, 1}});
    const Mesh plain = parse("# a room\nmtllib room.mtl\n\no room\ng walls floor\nusemtl white\ns off\n  v 0 0 0 1 # origin\n"
                             "v\t1 0 0\nv 0 1e0 0\nl 1 2\np 1\nvt 0.5\nf 1 \\\n 2 3\n");
    CHECK(plain.positions == std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(plain.triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK(same_mesh(parse("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2\\\r\n 3\r\n"), plain));
}

TEST_CASE("OBJ: errors name the line and what was expected", "[obj]")
{
    const auto refused = [](const std::string& text, int line, const std::string& reason)
    { CHECK_THROWS_WITH(parse(text), Contains("room.obj:" + std::to_string(line) + ": ") && Contains(reason)); };
    refused(square + "f 1 2 5\n", 5, "vertex 5, but only 4");
    refused(square + "f 1/1 2/2 3/3\n" + "vt 0 0\nvt 1 0\n", 5, "texture coordinate 3, but only 2");
    refused(square + "f 0 1 2\n", 5, "wrong index in '0'");
    refused(square + "f 99999999999 1 2\n", 5, "wrong index");
    for (const char* bad : {"f 1/2/3/4 2 3\n", "f a b c\n", "f 1.0 2 3\n", "f / 2 3\n"})
        refused(square + uvs + normals + bad, 11, "wrong index");
    refused(square + uvs + "f 1/1 2 3/3\n", 9, "one form");
    refused(square + uvs + "f 1/1 2/2 3/3\nf 1 2 3\n", 10, "all or none");
    refused(square + "f 1 2\n", 5, "a face of 2 corners");
    refused("v 0 0\n", 1, "after 2 numbers");
    refused("v 0 0 0 2\n", 1, "expected 'v X Y Z'");
    refused("v 0 0 0 1 1 1 1 1\n", 1, "unexpected '1'");
    refused("v 0 0 nan\n", 1, "finite number instead of 'nan'");
    refused("v 0 0 0,5\n", 1, "instead of '0,5'");
    refused("v 0 0 0 256 0 0\n", 1, "outside 0 to 1");
    refused("v 0 0 0\nv 0 0 0 1 0 0\n", 2, "all or none");
    refused("vt\n", 1, "after 0 numbers");
    refused("curv 0 1 1 2\n", 1, "unknown statement 'curv'");
    refused(square, 4, "without a triangle");
    refused(square + "f 1 2 3\\\n", 5, "must continue");
    CHECK_THROWS_AS(parse(""), Error);
}

TEST_CASE("OBJ: a file cut anywhere is refused, unless nothing of its last face can be missing", "[obj]")
{
    // Between two faces nothing in the format could tell.
    const std::string text = square + uvs + normals + "f 1/1/1 2/2/1 3/3/1\n";
    const std::string shorter = text.substr(0, text.size() - 4);
    check_cuts_are_refused(bytes_of(shorter), "room.obj:", [](const auto& cut) { parse_obj(cut, "room.obj"); });
    for (const auto* open : {"3", "3/", "3/1", "3/1\n# room"})
        CHECK(same_mesh(parse(shorter + open), parse(text)));
    std::string many;
    for (int i = 0; i < 30; ++i)
        many += "v " + std::to_string(i) + " 0 0\n";
    CHECK_THROWS_WITH(parse(many + "f 4 5 3"), Contains("room.obj:31: the line is not ended by a newline"));
    CHECK_THROWS_WITH(parse(many + "f 4 5 -2"), Contains("is not ended by a newline"));
    CHECK(parse(many + "f 4 5 29").triangles.size() == 1);
}

TEST_CASE("OBJ: differences between the programs that write it", "[obj]")
{
    const std::vector<std::string> alike{
        "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan 0 1\nf 1//1 2//1 3//7\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/ 2/ 3/\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvp 0.5 1\nvw 1\nf 1// 2// 3//\n"};
    for (const auto& text : alike)
        CHECK(same_mesh(parse(text), parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")));
    const std::vector<Rgb8> colors{{255, 0, 0}, {0, 128, 0}, {0, 0, 255}};
    CHECK(parse("v 0 0 0 255 0 0\nv 1 0 0 0 128 0\nv 0 1 0 0 0 255\nf 1 2 3\n").colors == colors);
    CHECK(parse("v 0 0 0 1 0 0 1\nv 1 0 0 0 0.5 0 1\nv 0 1 0 0 0 1 1\nf 1 2 3\n").colors == colors);
}

TEST_CASE("OBJ: materials are named with their lines, and some faces may have no texture coordinates", "[obj]")
{
    const std::string text = square + uvs +
                             "mtllib the room.mtl\nf 1 2 3\nusemtl wall #2\nf 1/1 2/2 3/3 4/4\nusemtl floor\nf 1/1 3/3 4/4\n"
                             "usemtl  wall #2 \nf 1 3 4\nf 1 1 3\n";
    MeshMaterials materials;
    MeshReadReport report;
    const Mesh mesh = parse_obj(bytes_of(text), "room.obj", {}, &report, &materials);
    REQUIRE(mesh.triangles.size() == 5);
    REQUIRE(materials.files.size() == 1);
    CHECK(materials.files[0].name == "the room.mtl");
    CHECK(materials.files[0].line == 9);
    REQUIRE(materials.names.size() == 2);
    CHECK(materials.names[0].name == "wall #2");
    CHECK(materials.of_face == std::vector<std::uint32_t>{MeshMaterials::none, 0, 0, 1, 0});
    CHECK(materials.has_texcoords == std::vector<std::uint8_t>{0, 1, 1, 1, 0});
    CHECK(mesh.texcoords[0] == Vec2f{0, 0});
    CHECK(std::vector(mesh.texcoords.begin() + 3, mesh.texcoords.begin() + 12) ==
          std::vector<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 1}, {0, 1}});
    CHECK(report.degenerate_dropped == 1);
    CHECK_THROWS_WITH(parse(text), Contains("room.obj:12: ") && Contains("all or none"));

    CHECK(parse_obj(bytes_of(square + "f 1 2 3\n"), "room.obj", {}, nullptr, &materials).texcoords.empty());
    CHECK(materials.files.empty());
    CHECK(materials.has_texcoords.empty());
}
