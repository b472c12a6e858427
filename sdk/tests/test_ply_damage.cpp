#include "catch.h"
#include "ply_samples.h"

#include <fresco/error.h>
#include <fresco/mesh_io.h>

using namespace fresco;
using Catch::Contains;

namespace
{

/// A file with everything the reader knows, in one encoding.
std::string rich_ply(PlyEncoding encoding)
{
    PlyText ply(encoding);
    ply.line("element vertex 4").line("property float x").line("property double y").line("property float z");
    ply.line("property uchar red").line("property uchar green").line("property uchar blue").line("property short label");
    ply.line("element face 2").line("property list uchar int vertex_indices").line("property list uchar float texcoord");
    ply.line("property int chart").line("element strip 1").line("property list int uchar ids").line("end_header");
    const Mesh mesh = folded_square();
    for (std::size_t i = 0; i < 4; ++i)
    {
        ply.value("float", mesh.positions[i].x).value("double", mesh.positions[i].y).value("float", mesh.positions[i].z);
        ply.values("uchar", {12.0, 34.0, 56.0}).value("short", -3).end_row();
    }
    for (const auto& t : mesh.triangles)
    {
        ply.value("uchar", 3).values("int", {double(t[0]), double(t[1]), double(t[2])});
        ply.value("uchar", 6).values("float", {0, 0.25, 1, 0.125, 0.5, 1}).value("int", 11).end_row();
    }
    ply.value("int", 4).values("uchar", {1, 2, 3, 44}).end_row();
    return ply.text;
}

}  // namespace

TEST_CASE("PLY damage: the undamaged file is read", "[ply]")
{
    const Mesh expected = parse_ply(bytes_of(rich_ply(PlyEncoding::ascii)), "ascii");
    CHECK(expected.texcoords.size() == 6);
    CHECK(expected.charts == std::vector<std::uint32_t>{11, 11});
    CHECK(same_mesh(parse_ply(bytes_of(rich_ply(PlyEncoding::little)), "little"), expected));
    CHECK(same_mesh(parse_ply(bytes_of(rich_ply(PlyEncoding::big)), "big"), expected));
}

TEST_CASE("PLY damage: a file cut at any byte is refused", "[ply]")
{
    for (const auto encoding : all_encodings)
        for (const std::string& text : {rich_ply(encoding), ply_of(folded_square(), encoding)})
            for (std::size_t size = 0; size < text.size(); ++size)
            {
                INFO("encoding " << static_cast<int>(encoding) << ", the first " << size << " of " << text.size() << " bytes");
                // A copy of exactly this size, so that a sanitizer sees a read beyond it.
                const std::vector<char> cut(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size));
                CHECK_THROWS_AS(parse_ply(std::as_bytes(std::span(cut)), "cut.ply"), Error);
            }
}

TEST_CASE("PLY damage: flipped, inserted and removed bytes give an error or a valid mesh", "[ply]")
{
    TestRandom random(2024);
    std::size_t refused = 0;
    std::size_t accepted = 0;
    for (const auto encoding : all_encodings)
    {
        const std::string good = rich_ply(encoding);
        for (int trial = 0; trial < 700; ++trial)
        {
            std::string text = good;
            for (std::size_t change = 0; change < 1 + random.below(3); ++change)
            {
                const std::size_t at = random.below(text.size());
                if (trial % 7 == 5)
                    text.insert(at, 1, static_cast<char>(random.below(256)));
                else if (trial % 7 == 6)
                    text.erase(at, 1);
                else
                    text[at] = static_cast<char>(text[at] ^ static_cast<char>(1U << random.below(8)));
            }
            try
            {
                require_valid(parse_ply(bytes_of(text), "flipped.ply"));
                ++accepted;
            }
            catch (const Error& error)
            {
                CHECK_THAT(error.what(), Contains("flipped.ply"));
                ++refused;
            }
        }
    }
    CHECK(refused > 600);
    CHECK(accepted > 100);
}

TEST_CASE("PLY damage: counts beyond the file's size are refused before anything is allocated", "[ply]")
{
    // Far more than the memory of any machine: an attempt to allocate would throw something else.
    const std::string huge = "100000000000000000";
    const std::string format[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const MeshLimits no_limits{.max_vertices = SIZE_MAX, .max_faces = SIZE_MAX};
    for (const auto& name : format)
    {
        const std::string begin = "ply\nformat " + name + " 1.0\n";
        const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
        const std::string list = "property list uchar int vertex_indices\n";
        for (const auto& [vertices, faces] : {std::pair{huge, std::string("1")}, std::pair{std::string("3"), huge}})
        {
            std::string text = begin;
            text += "element vertex " + vertices + "\n" + xyz + "element face " + faces + "\n" + list + "end_header\n0 0 0\n";
            CHECK_THROWS_WITH(parse_ply(bytes_of(text), "huge.ply", no_limits), Contains("do not fit into the 6 bytes"));
        }
        const std::string other = begin + "element other " + huge + "\nproperty list uchar char a\nend_header\n";
        CHECK_THROWS_WITH(parse_ply(bytes_of(other), "huge.ply", no_limits), Contains("huge.ply:3: ") && Contains("do not fit"));
    }
    // More vertices than there could be, though each element by itself fits.
    const std::string both = "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                             "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n" +
                             std::string(30, '\0');
    CHECK_THROWS_WITH(parse_ply(bytes_of(both), "both.ply"), Contains("2 elements 'face' of at least 13 bytes"));
}

TEST_CASE("PLY damage: a list longer than the file is refused before anything is allocated", "[ply]")
{
    const std::string list_types[] = {"property list uint int vertex_indices", "property list int uchar other"};
    for (const auto& declared : list_types)
    {
        const bool indices = declared.find("vertex_indices") != std::string::npos;
        PlyText ply(PlyEncoding::little);
        ply.line("element vertex 3").line("property float x").line("property float y").line("property float z");
        ply.line("element face 1").line(declared);
        if (!indices)
            ply.line("property list uchar uchar vertex_indices");
        ply.line("end_header").values("float", {0, 0, 0, 1, 0, 0, 0, 1, 0});
        ply.value(indices ? "uint" : "int", indices ? 4'000'000'000.0 : 2'000'000'000.0);
        ply.values("uint", {0, 1, 2});
        CHECK_THROWS_WITH(parse_ply(bytes_of(ply.text), "list.ply"), Contains("beyond the end of the file"));
    }
    PlyText negative(PlyEncoding::big);
    negative.line("element vertex 3").line("property float x").line("property float y").line("property float z");
    negative.line("element face 1").line("property list int int vertex_indices").line("end_header");
    negative.values("float", {0, 0, 0, 1, 0, 0, 0, 1, 0}).value("int", -3).values("int", {0, 1, 2});
    CHECK_THROWS_WITH(parse_ply(bytes_of(negative.text), "list.ply"), Contains("negative length"));
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
