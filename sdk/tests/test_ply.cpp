#include "comma_locale.h"
#include "cut_bytes.h"
#include "ply_samples.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <cmath>
#include <regex>

using namespace fresco;

namespace
{

Mesh parse(const std::string& text, const MeshLimits& limits = {})
{
    return parse_ply(bytes_of(text), "room.ply", limits);
}

std::string text_of(const std::vector<std::byte>& bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// An ASCII file of a triangle with other face or vertex lines.
std::string triangle_ply(const std::string& vertex_properties, const std::string& vertices, const std::string& face_properties,
                         const std::string& faces, std::size_t face_count = 1)
{
    return "ply\nformat ascii 1.0\nelement vertex 3\n" + vertex_properties + "element face " + std::to_string(face_count) + "\n" +
           face_properties + "end_header\n" + vertices + faces;
}

/// Everything that the reader knows, and elements and properties between it that it does not.
const char* const rich = R"(ply
format ascii 1.0
obj_info scanner 3
element camera 2
property double focal
property uchar id
element face 1
property float area
property list ushort double weights
property list int ushort vertex_index
property list uchar float texcoord
property int chart
element vertex 3
property double y
property short label
property float x
property list uchar float extra
property float z
property uchar red
property uchar green
property uchar blue
element strip 2
property list uchar short ids
end_header
1.5 4
2.5 5
0.5 2 1 2 3 2 1 0 6 0 0.25 1 0.125 0.5 1 11
0 -1 10 0 0.5 12 34 56
1 -1 11 1 0.125 0.5 12 34 56
2 -1 12 2 0.125 0.125 0.5 12 34 56
2 -5 6
1 3
)";

const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
const std::string three = "0 0 0\n1 0 0\n0 1 0\n";
const std::string index_list = "property list uchar int vertex_indices\n";

}  // namespace

TEST_CASE("PLY: every encoding with every coordinate, index and count type gives the same mesh", "[ply]")
{
    const Mesh expected = folded_square();
    for (const std::string& encoding : all_encodings)
        for (const char* coordinate : {"float", "double"})
            for (const char* index : {"char", "uchar", "short", "ushort", "int", "uint"})
                for (const char* count : {"char", "uchar", "short", "ushort", "int", "uint"})
                {
                    INFO(encoding << ' ' << coordinate << ' ' << index << ' ' << count);
                    CHECK(same_mesh(parse(ply_of(expected, encoding, {coordinate, index, count})), expected));
                }
}

TEST_CASE("PLY: what to_ply writes is read back bit by bit", "[ply]")
{
    Random random(7);
    for (int variant = 0; variant < 8; ++variant)
    {
        Mesh mesh = testing::grid(7, [&](float, float) { return static_cast<float>(random.uniform() - 0.5); });
        mesh.positions[5].x = -0.0F;
        mesh.positions[6].x = 1e-40F;
        if ((variant & 1) != 0)
            mesh.colors.assign(mesh.positions.size(), {static_cast<std::uint8_t>(random.below(256)), 7, 255});
        if ((variant & 2) != 0)
            testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x, p.z}; });
        if ((variant & 4) != 0)
            mesh.charts.assign(mesh.triangles.size(), 2147483647U);
        CHECK(same_mesh(parse_ply(to_ply(mesh), "round trip"), mesh));
    }
    Mesh mesh = folded_square();
    mesh.triangles[1][2] = 4;
    CHECK_THROWS_AS(to_ply(mesh), Error);
    mesh = folded_square();
    mesh.charts = {0, 2147483648U};
    CHECK_THROWS_WITH(to_ply(mesh), Contains("chart numbers up to 2147483647"));
}

TEST_CASE("PLY: the texture's size is kept, in a comment", "[ply]")
{
    Mesh mesh = folded_square();
    mesh.texcoords.resize(3 * mesh.triangles.size());
    const std::string plain = text_of(to_ply(mesh));
    mesh.texture_px = 8192;
    CHECK(parse_ply(to_ply(mesh), "room.ply").texture_px == 8192);
    CHECK(parse(plain).texture_px == 0);
    for (const char* wrong : {"", " 0", " 2k", " 262145"})
    {
        std::string text = plain;
        text.insert(text.find("element"), std::string("comment texture_px") + wrong + "\n");
        CHECK_THROWS_WITH(parse(text), Contains("room.ply:3: ") && Contains("expected 'comment texture_px' and 1 to 262144"));
    }
}

TEST_CASE("PLY and OBJ: polygons are fanned, faces that name a vertex twice are dropped, both are counted, and limits are kept")
{
    const std::string ply = triangle_ply(xyz, three, index_list, "4 0 1 2 1\n3 0 0 1\n4 2 1 0 1\n", 3);
    for (const std::string& text : {ply, std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 2\nf 1 1 2\nf 3 2 1 2\n")})
    {
        MeshReadReport report;
        const auto read = [&](std::size_t vertices, std::size_t faces)
        {
            const MeshLimits limits{.max_vertices = vertices, .max_faces = faces};
            return text == ply ? parse_ply(bytes_of(text), "room", limits, &report)
                               : parse_obj(bytes_of(text), "room", limits, &report);
        };
        CHECK(read(3, 4).triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 1}, {2, 1, 0}, {2, 0, 1}});
        CHECK((report.polygons_split == 2 && report.degenerate_dropped == 1));
        CHECK_THROWS_WITH(read(2, 4), Contains(text == ply ? "3 vertices; the limit is 2" : "more than 2 vertices"));
        CHECK_THROWS_WITH(read(3, 3), Contains("more than 3 triangles"));
    }
    CHECK_THROWS_WITH(parse(triangle_ply(xyz, three, index_list, "3 0 0 1\n")), Contains("no triangle is left"));
}

TEST_CASE("PLY: texture coordinates of corners and of vertices, and charts", "[ply]")
{
    const std::string face = "property int chart\nproperty list uchar double texcoord\n" + index_list;
    const Mesh corners = parse(triangle_ply(xyz, three, face, "9 6 0 0.5 1 0 0 1 3 0 1 2\n7 8 0 0 1 0 1 1 0 1 4 0 1 2 1\n", 2));
    CHECK(corners.charts == std::vector<std::uint32_t>{9, 7, 7});
    CHECK(corners.texcoords == std::vector<Vec2f>{{0, 0.5F}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}});

    const std::vector<std::pair<std::string, std::string>> names{
        {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
    for (const auto& [u, v] : names)
    {
        const auto vertex = "property float " + u + "\nproperty double " + v + "\n" + xyz;
        const Mesh mesh = parse(triangle_ply(vertex, "0.5 0.25 0 0 0\n1 0 1 0 0\n0 1 0 1 0\n", index_list, "3 2 0 1\n"));
        CHECK(mesh.texcoords == std::vector<Vec2f>{{0, 1}, {0.5F, 0.25F}, {1, 0}});
        CHECK(mesh.positions[1] == Vec3f{1, 0, 0});
    }
}

TEST_CASE("PLY: line ends, comments, blanks and number forms", "[ply]")
{
    const Mesh expected = parse(triangle_ply(xyz, three, index_list, "3 0 1 2\n"));
    const auto crlf = [](const std::string& text) { return std::regex_replace(text, std::regex("\n"), "\r\n"); };
    CHECK(same_mesh(parse(crlf(triangle_ply(xyz, three, index_list, "3 0 1 2\n"))), expected));
    const auto binary = ply_of(folded_square(), "binary_little_endian");
    const auto body = binary.find("end_header\n") + 11;
    CHECK(same_mesh(parse(crlf(binary.substr(0, body)) + binary.substr(body)), folded_square()));
    CHECK(same_mesh(parse(triangle_ply("comment a\n" + xyz + "comment\n", three, index_list, " 3\t0  1 2 \n\n \n")), expected));
    CHECK(parse(triangle_ply(xyz, "+0 0.0e5 1e-60\n1.0 0 0\n.0 10E-1 -0\n", index_list, "+3 0 1 2\n")).positions ==
          expected.positions);
}

TEST_CASE("PLY: the last newline may be missing where the last number cannot go on, and lines may have more numbers", "[ply]")
{
    const auto with = [](std::size_t vertices, const std::string& last)
    {
        std::string text = triangle_ply(xyz, "", index_list, last);
        text.replace(text.find("vertex 3"), 8, "vertex " + std::to_string(vertices));
        std::string rows;
        for (std::size_t i = 0; i < vertices; ++i)
            rows += std::to_string(i) + " " + std::to_string(i * i) + " 0\n";
        return text.insert(text.find("end_header\n") + 11, rows);
    };
    const Mesh expected = parse(with(3, "3 0 1 2\n"));
    CHECK(same_mesh(parse(with(3, "3 0 1 2")), expected));
    CHECK(same_mesh(parse(with(3, "3 0 1 2 255 -1.5 0\n")), expected));
    CHECK(same_mesh(parse(with(20, "3 0 1 2")), parse(with(20, "3 0 1 2\n"))));
    CHECK(parse(with(21, "3 1 2 0")).triangles == std::vector<Triangle>{{1, 2, 0}});
    CHECK(parse(with(21, "3 1 0 2 7")).triangles == std::vector<Triangle>{{1, 0, 2}});
    CHECK_THROWS_WITH(parse(with(21, "3 0 1 2")), Contains("room.ply:31: the line is not ended by a newline"));
    const std::string chart = "property short chart\n";
    CHECK(parse(triangle_ply(xyz, three, index_list + chart, "3 0 1 2 3277")).charts == std::vector<std::uint32_t>{3277});
    CHECK_THROWS_WITH(parse(triangle_ply(xyz, three, index_list + chart, "3 0 1 2 3276")), Contains("not ended by a newline"));
    CHECK_THROWS_WITH(
        parse(triangle_ply(xyz, three, index_list + "property list uchar float texcoord\n", "3 0 1 2 6 0 0 1 0 0 1")),
        Contains("not ended by a newline"));
}

TEST_CASE("PLY: colors by other names and types, of vertices and of faces; whole coordinates; normals that are no numbers",
          "[ply]")
{
    const auto colors = [](const std::string& type, const std::string& names, const std::string& one, const std::string& other)
    {
        std::string properties = xyz;
        for (std::size_t at = 0; at < names.size(); at = names.find(' ', at) + 1)
            if (properties += "property " + type + " " + names.substr(at, names.find(' ', at) - at) + "\n";
                names.find(' ', at) == std::string::npos)
                break;
        return parse(triangle_ply(properties, "0 0 0 " + one + "\n1 0 0 " + one + "\n0 1 0 " + other + "\n", index_list,
                                  "3 0 1 2\n"))
            .colors;
    };
    const std::vector<Rgb8> expected{{255, 0, 51}, {255, 0, 51}, {0, 102, 0}};
    for (const char* names : {"red green blue", "diffuse_red diffuse_green diffuse_blue", "r g b"})
    {
        CHECK(colors("uchar", names, "255 0 51", "0 102 0") == expected);
        CHECK(colors("int", names, "255 0 51", "0 102 0") == expected);
        CHECK(colors("ushort", names, "65535 0 13107", "0 26214 0") == expected);
        CHECK(colors("ushort", names, "255 0 51", "0 102 0") == expected);
        CHECK(colors("float", names, "1 0 0.2", "0 0.4 0") == expected);
        CHECK(colors("double", names, "255 0 51", "0 102 0") == expected);
    }
    for (const auto& [type, value] :
         {std::pair{"float", "nan"}, {"float", "255.5"}, {"float", "-0.1"}, {"int", "256"}, {"short", "-1"}})
        CHECK_THROWS_WITH(colors(type, "red green blue", "0 0 0", std::string("0 0 ") + value),
                          Contains("room.ply:15: the color is outside 0 to 255"));
    CHECK(colors("float", "r nx ny", "0.5 nan inf", "0.5 nan inf").empty());
    CHECK(parse(triangle_ply("property int x\nproperty short y\nproperty uchar z\n", "-7 0 0\n1 -300 0\n0 1 255\n", index_list,
                             "3 0 1 2\n"))
              .positions == std::vector<Vec3f>{{-7, 0, 0}, {1, -300, 0}, {0, 1, 255}});

    const auto faces = [](const std::string& type, const std::string& rows, MeshMaterials* materials)
    {
        const std::string color = "property " + type + " red\nproperty " + type + " green\nproperty " + type + " blue\n";
        return parse_ply(bytes_of(triangle_ply(xyz, three, index_list + color, rows, 3)), "room.ply", {}, nullptr, materials);
    };
    for (const auto& [type, one, other] :
         {std::array{"uchar", "255 0 51", "0 102 0"}, {"ushort", "65535 0 13107", "0 26214 0"}, {"float", "1 0 0.2", "0 0.4 0"}})
    {
        MeshMaterials materials;
        const std::string rows = "3 0 1 2 " + std::string(one) + "\n4 2 1 0 2 " + other + "\n3 1 2 0 " + one + "\n";
        CHECK(faces(type, rows, &materials).colors.empty());
        REQUIRE(materials.names.size() == 2);
        CHECK(materials.names[0].name == "#ff0033");
        CHECK(materials.names[1].name == "#006600");
        CHECK(materials.of_face == std::vector<std::uint32_t>{0, 1, 0});
        CHECK(faces(type, rows, nullptr).triangles.size() == 3);
        CHECK_THROWS_WITH(faces(type, "3 0 1 2 0 0 -1\n3 0 1 2 0 0 0\n3 0 1 2 0 0 0\n", &materials), Contains("room.ply:16: "));
    }
}

TEST_CASE("PLY: damaged files and headers are refused by place and reason", "[ply]")
{
    const auto refused = [](const std::string& text, const std::string& reason)
    { CHECK_THROWS_WITH(parse(text), Contains("room.ply") && Contains(reason)); };
    const auto face = [&](const std::string& line, const std::string& reason)
    { refused(triangle_ply(xyz, three, index_list, line), reason); };
    face("3 0 1 3\n", "room.ply:13: the face names vertex 3; expected 0 to 2");
    face("3 0 -1 2\n", "names vertex -1");
    face("2 0000 1\n", "a face of 2 corners");
    face("3 0 0001\n", "room.ply:13: the line ends");
    face("3 0 1 2 2 x\n", "unexpected 'x' after the last value");
    face("3 0 1 2\n3 0 1 2\n", "room.ply:14: unexpected '3' after the last element");
    face("-3 0 1 2\n", "expected a value of type uchar instead of '-3'");
    face("200 0 1 2\n", "longer than its line");
    face("3 0 1.5 2\n", "type int instead of '1.5'");
    for (const char* bad : {"nan", "inf", "-inf", "1e39", "1e400", "x", "0x1", "1,5", "--1", "+-1", "1.0.0", "1e"})
        refused(triangle_ply(xyz, std::string("0 0 0\n1 ") + bad + " 0\n0 1 0\n", index_list, "3 0 1 2\n"), "room.ply:11: ");
    refused(triangle_ply(xyz, three, index_list, "", 0), "no faces");
    std::string strips = triangle_ply(xyz, three, index_list, "3 0 1 2\n");
    refused(strips.replace(strips.find("element face"), 12, "element tristrips"), "triangle strips ('tristrips'), which are not");
    refused("", "room.ply:1: expected the line 'ply'");
    refused("solid cube\n", "not a PLY file");

    Mesh mesh = folded_square();
    mesh.positions[2].y = std::nanf("");
    refused(ply_of(mesh, "binary_little_endian"), "room.ply: byte 287: the coordinate is not a finite number");
    mesh = folded_square();
    mesh.triangles[1][1] = 200;
    refused(ply_of(mesh, "binary_big_endian"), "names vertex 200");
    refused(ply_of(folded_square(), "binary_little_endian") + "\n", "1 bytes after the last element");

    const std::string begin = "ply\nformat ascii 1.0\n";
    refused("ply\nelement vertex 3\n", "expected 'format");
    refused("ply\nformat ascii 2.0\n", "format version '2.0'");
    refused("ply\nformat utf8 1.0\n", "unknown format 'utf8'");
    refused(begin + "property float x\n", "before the first element");
    refused(begin + "element vertex many\n", "instead of 'many'");
    refused(begin + "element vertex 3 3\n", "unexpected '3'");
    refused(begin + "element vertex 3\nelement vertex 3\n", "a second element");
    refused(begin + "element vertex 3\nproperty float x\nproperty float x\n", "a second property");
    refused(begin + "element vertex 3\nproperty half x\n", "unknown type 'half'");
    refused(begin + "element vertex 3\nproperty list float int x\n", "integer type");
    refused(begin + "element vertex 0\nelement face 5\nend_header\n", "no properties");
    refused(begin + "vertices 3\n", "instead of 'vertices'");
    refused(begin + "element vertex 3\n" + xyz + "end_header\n" + three, "missing element 'face'");

    const auto vertices = [&](const std::string& properties, const std::string& reason)
    { refused(triangle_ply(properties, "0 0 0 1\n0 0 0 1\n0 0 0 1\n", index_list, "3 0 1 2\n"), reason); };
    vertices("property float x\nproperty float y\n", "'z' is missing");
    vertices("property list uchar int x\nproperty int y\nproperty int z\n", "'x' must be a number");
    refused(triangle_ply(xyz + "property uchar red\nproperty float green\nproperty uchar blue\n",
                         "0 0 0 1 1 1\n0 0 0 1 1 1\n0 0 0 1 1 1\n", index_list, "3 0 1 2\n"),
            "'green' must be a number of the type of the other colors");
    vertices(xyz + "property uchar red\n", "'green' is missing");
    const auto faces = [&](const std::string& properties, const std::string& line, const std::string& reason)
    { refused(triangle_ply(xyz, three, properties, line), reason); };
    faces("property list uchar float vertex_indices\n", "3 0 1 2\n", "integer type");
    faces("property uchar quality\n", "3\n", "no list vertex_indices");
    faces(index_list + "property list uchar float texcoord\n", "3 0 1 2 4 0 0 1 1\n", "one per corner");
    faces(index_list + "property list uchar float texcoord\n", "3 0 1 2 5 0 0 1 1 1\n", "u and v");
    faces(index_list + "property int chart\n", "3 0 1 2 -1\n", "chart -1");
    faces(index_list + "property float chart\n", "3 0 1 2 1\n", "integer type");
}

TEST_CASE("PLY and OBJ: numbers do not depend on the locale", "[ply][obj]")
{
    const CommaLocale comma("PLY and OBJ");
    CHECK(same_mesh(parse(ply_of(folded_square(), "ascii")), folded_square()));
    CHECK(parse_obj(bytes_of("v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "room.obj").positions[0].x == 0.5F);
    CHECK_THROWS_AS(parse_obj(bytes_of("v 0,5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "room.obj"), Error);
}

TEST_CASE("PLY: pictures are named with their lines, and faces choose one by texnumber", "[ply]")
{
    const std::string header = "comment TextureFile the floor.png\ncomment TextureFile wall.jpg\n";
    const std::string text =
        triangle_ply(header + xyz, three, index_list + "property list uchar float texcoord\nproperty int texnumber\n",
                     "3 0 1 2 6 0 0 1 0 2 1 1\n3 0 1 2 6 0 0 1 0 2 1 0\n3 0 1 2 6 0 0 1 0 2 1 -1\n", 3);
    MeshMaterials materials;
    const Mesh mesh = parse_ply(bytes_of(text), "room.ply", {}, nullptr, &materials);
    REQUIRE(materials.files.size() == 2);
    CHECK(materials.files[0].name == "the floor.png");
    CHECK(materials.files[1].line == 5);
    CHECK(materials.of_face == std::vector<std::uint32_t>{1, 0, MeshMaterials::none});
    CHECK(mesh.texcoords[2] == Vec2f{2, 1});
    std::string other = text;
    other.replace(other.find("comment TextureFile wall.jpg"), 20, "comment SomeOtherTag");
    CHECK_THROWS_WITH(parse_ply(bytes_of(other), "room.ply", {}, nullptr, &materials),
                      Contains("texnumber 1, but the header names 1 pictures"));
    CHECK(parse(other).triangles.size() == 3);
}

TEST_CASE("PLY: unknown elements and properties are skipped in every encoding, and a file cut at any byte is refused", "[ply]")
{
    for (const std::string& encoding : all_encodings)
    {
        const std::string text = in_encoding(encoding, rich);
        const Mesh mesh = parse(text);
        CHECK(mesh.positions == std::vector<Vec3f>{{10, 0, 0.5F}, {11, 1, 0.5F}, {12, 2, 0.5F}});
        CHECK(mesh.colors == std::vector<Rgb8>(3, {12, 34, 56}));
        CHECK(mesh.triangles == std::vector<Triangle>{{2, 1, 0}});
        CHECK(mesh.texcoords == std::vector<Vec2f>{{0, 0.25F}, {1, 0.125F}, {0.5F, 1}});
        CHECK(mesh.charts == std::vector<std::uint32_t>{11});
        // The last newline of a text may be missing.
        check_cuts_are_refused(bytes_of(text).first(text.size() - (encoding == "ascii" ? 1 : 0)), "cut.ply",
                               [](const auto& cut) { parse_ply(cut, "cut.ply"); });
    }
}

TEST_CASE("PLY damage: counts and lists beyond the file's size are refused before anything is allocated", "[ply]")
{
    // Far more than the memory of any machine: an attempt to allocate would throw something else.
    const std::string huge = "100000000000000000";
    const MeshLimits no_limits{.max_vertices = SIZE_MAX, .max_faces = SIZE_MAX};
    const auto refused = [&](const std::string& text, const std::string& reason)
    { CHECK_THROWS_WITH(parse(text, no_limits), Contains("room.ply:") && Contains(reason)); };
    for (const std::string& encoding : all_encodings)
    {
        const std::string begin = "ply\nformat " + encoding + " 1.0\n";
        const auto counts = [&](const std::string& vertices, const std::string& faces)
        {
            return begin + "element vertex " + vertices + "\n" + xyz + "element face " + faces + "\n" + index_list +
                   "end_header\n0 0 0\n";
        };
        refused(counts(huge, "1"), "do not fit into the 6 bytes");
        refused(counts("3", huge), "do not fit into the 6 bytes");
        refused(begin + "element other " + huge + "\nproperty list uchar char a\nend_header\n", "do not fit");
    }
    for (const auto& [type, reason] : {std::pair{"uint", "beyond the end of the file"}, {"int", "negative length"}})
    {
        // The count of the last face.
        std::string text = ply_of(folded_square(), "binary_little_endian", {.count = type});
        refused(text.replace(text.size() - 16, 4, 4, '\xff'), reason);
    }
}

TEST_CASE("PLY damage: a header of very many names is refused before they are all compared", "[ply]")
{
    const std::string begin = "ply\nformat ascii 1.0\n";
    std::string elements;
    std::string properties = "element vertex 3\n";
    for (int i = 0; i < 30'000; ++i)
    {
        elements += "element e" + std::to_string(i) + " 0\n";
        properties += "property float p" + std::to_string(i) + "\n";
    }
    CHECK_THROWS_WITH(parse_ply(bytes_of(begin + elements), "many.ply"), Contains("many.ply:259: more than 256 elements"));
    CHECK_THROWS_WITH(parse_ply(bytes_of(begin + properties), "many.ply"), Contains("many.ply:1028: more than 1024 properties"));
}
