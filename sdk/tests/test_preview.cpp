#include "../src/packed_mesh.h"
#include "catch.h"
#include "stored_png.h"

#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/preview.h>
#include <fresco/testing.h>
#include <fresco/texture.h>

#include <cmath>
#include <cstdint>
#include <cstring>

using namespace fresco;

namespace
{

/// Encodes JPEG as PNG; a test looks at sizes and colors.
class Codec final : public stored_png::Codec
{
  public:
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode_png(image); }
};

/// About the world's y axis, which points down: a camera turned by `turn`, and down by `pitch`.
Frame looking(double turn, double pitch)
{
    Frame frame;
    const Mat3 turned{std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)};
    const Mat3 down{1, 0, 0, 0, std::cos(pitch), std::sin(pitch), 0, -std::sin(pitch), std::cos(pitch)};
    frame.color.world_from_camera.rotation = turned * down;
    return frame;
}

std::vector<std::string> names_of(const Preview& page)
{
    std::vector<std::string> names;
    if (const Value* pictures = page.value().find("pictures"))
        for (const Value& picture : pictures->as_list())
            names.push_back(picture.at("name").as_string());
    return names;
}

using Names = std::vector<std::string>;

struct Unpacked
{
    std::vector<std::array<int, 5>> values;
    std::vector<std::size_t> corners;
};

/// As the page does it.
Unpacked unpacked(const detail::PackedMesh& room)
{
    std::size_t at = 0;
    const auto number = [&]
    {
        std::uint32_t value = 0;
        for (unsigned shift = 0;; shift += 7)
        {
            const auto byte = static_cast<std::uint32_t>(room.bytes.at(at++));
            value |= (byte & 127U) << shift;
            if (byte < 128)
                return value;
        }
    };
    Unpacked result;
    std::array<int, 5> before{};
    while (at < room.bytes.size())
    {
        const std::uint32_t ago = number();
        result.corners.push_back(result.values.size() - ago);
        if (ago == 0)
            for (int& value : result.values.emplace_back(before))
            {
                const std::uint32_t difference = number();
                value += static_cast<int>(difference >> 1U) ^ -static_cast<int>(difference & 1U);
            }
        before = result.values.at(result.corners.back());
    }
    return result;
}

}  // namespace

TEST_CASE("a packed mesh has the mesh's corners to half a step")
{
    Mesh mesh;
    mesh.positions = {{-1, 0, 2}, {3, 0.25F, 2}, {3, 1, 2}, {-1, 1, 2}, {99, 99, 99}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    // The faces share an edge; vertex 0 has two texcoords.
    mesh.texcoords = {{0.1F, 0.2F}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    const detail::PackedMesh room = detail::pack_mesh(mesh);
    CHECK(room.vertices == 5);
    CHECK(room.triangles == 2);
    CHECK(room.low == std::array<double, 3>{-1, 0, 2});
    CHECK(room.extent == std::array<double, 3>{4, 1, 0});  // The vertex of no face does not count.
    const Unpacked found = unpacked(room);
    REQUIRE(found.values.size() == 5);
    REQUIRE(found.corners.size() == 6);
    for (std::size_t corner = 0; corner < 6; ++corner)
    {
        REQUIRE(found.corners[corner] < room.vertices);
        const auto& packed = found.values[found.corners[corner]];
        const Vec3f position = mesh.positions[mesh.triangles[corner / 3][corner % 3]];
        const Vec2f uv = mesh.texcoords[corner];
        CHECK(std::abs(room.low[0] + packed[0] * room.extent[0] / 65535 - position.x) <= 4.0 / 65535 / 2 + 1e-7);
        CHECK(std::abs(room.low[1] + packed[1] * room.extent[1] / 65535 - position.y) <= 1.0 / 65535 / 2 + 1e-7);
        CHECK(packed[2] == 0);
        CHECK(std::abs(packed[3] / 65535.0 - uv.x) <= 0.5 / 65535 + 1e-7);
        CHECK(std::abs(packed[4] / 65535.0 - uv.y) <= 0.5 / 65535 + 1e-7);
    }
}

TEST_CASE("a packed mesh of many faces in a wild order has all of them once, in 12 bytes per vertex and 4 per face at most")
{
    Mesh mesh;
    constexpr std::uint32_t side = 60;
    for (std::uint32_t y = 0; y <= side; ++y)
        for (std::uint32_t x = 0; x <= side; ++x)
            mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(x * y % 7)});
    for (std::uint32_t cell = 0; cell < side * side; ++cell)
    {
        const std::uint32_t wild = cell * 1009U % (side * side);  // Coprime: every cell once.
        const std::uint32_t at = wild / side * (side + 1) + wild % side;
        mesh.triangles.push_back({at, at + 1, at + side + 2});
        mesh.triangles.push_back({at, at + side + 2, at + side + 1});
    }
    mesh.triangles.push_back(mesh.triangles.front());  // A face twice, and an edge of more than two faces.
    mesh.triangles.push_back({0, 1, 5});
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
            mesh.texcoords.push_back({mesh.positions[vertex].x / side, mesh.positions[vertex].y / side});
    const detail::PackedMesh room = detail::pack_mesh(mesh);
    CHECK(room.bytes.size() <= 12 * room.vertices + 4 * room.triangles);
    const Unpacked found = unpacked(room);
    REQUIRE(found.values.size() == mesh.positions.size());
    std::multiset<std::array<std::array<long, 3>, 3>> expected;
    std::multiset<std::array<std::array<long, 3>, 3>> faces;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        std::array<std::array<long, 3>, 3> meant{};
        std::array<std::array<long, 3>, 3> seen{};
        for (std::size_t corner = 0; corner < 3; ++corner)
        {
            const Vec3f p = mesh.positions[mesh.triangles[face][corner]];
            meant[corner] = {std::lround(p.x), std::lround(p.y), std::lround(p.z)};
            for (std::size_t axis = 0; axis < 3; ++axis)
                seen[corner][axis] = std::lround(room.low[axis] + found.values[found.corners[3 * face + corner]][axis] *
                                                                      room.extent[axis] / 65535);
        }
        expected.insert(meant);
        faces.insert(seen);
    }
    CHECK(faces == expected);
}

TEST_CASE("up is found from cameras that look down on all sides, and on one side")
{
    const Codec codec;
    const auto up_of = [&](const Frames& frames)
    {
        Preview page(codec);
        frames.preview(page);
        return page.value().at("cameras").at("up").as_list().at(1).as_double();
    };
    Frames around;
    for (const double turn : {0.0, 0.7, 1.5, 2.0})
        around.frames.push_back(looking(turn, 0.6));
    CHECK(up_of(around) < -0.999);
    Frames one;
    one.frames.push_back(looking(0.3, 0.2));
    CHECK(up_of(one) < -0.97);
    // Of earlier frames that nobody made pictures of there is nothing to see.
    Preview page(codec);
    page.last = false;
    one.preview(page);
    CHECK(page.value() == Value(Value::Map{}));
}

TEST_CASE("frames show what the cameras saw where others made pictures, files the pictures asked for")
{
    const Codec codec;
    const testing::TemporaryFolder folder;
    const auto write = [&](const std::string& name) { write_file(folder.path() / name, codec.encode_png(Raster8(4, 2, 3))); };
    Frames frames;
    for (const char* name : {"a", "b", "c"})
    {
        write(std::string(name) + ".png");
        frames.frames.push_back(looking(0, 0));
        frames.frames.back().sequence = "s";
        frames.frames.back().name = name;
        frames.frames.back().color.intrinsics = {4, 2, 1, 1, 0, 0};
        frames.frames.back().color_picture.path = folder.path() / (std::string(name) + ".png");
    }
    Preview seen(codec);
    seen.last = false;
    seen.names = {"views/s_b.png", "other/s_b.jpg", "views/x.png"};
    frames.preview(seen);
    CHECK(names_of(seen) == Names{"s_b"});
    CHECK(seen.value().at("pictures").as_list()[0].at("pose").at("forward") == parse_json("[0.0, 0.0, 1.0]"));
    CHECK(seen.value().find("cameras") != nullptr);

    Files files;
    files.loaded_from = folder.path();
    files.names = {"a.png", "b.png", "c.png", "note.txt"};
    Preview all(codec);
    files.preview(all);
    CHECK(names_of(all) == Names{"a.png", "b.png", "c.png"});
    Preview some(codec);
    some.most_pictures = 1;
    files.preview(some);
    CHECK(names_of(some) == Names{"b.png"});
    Preview chosen(codec);
    chosen.names = {"c.png"};
    files.preview(chosen);
    CHECK(names_of(chosen) == Names{"c.png"});
    auto compressed = codec.encode_png(Raster8(4, 2, 3));
    compressed.at(43) = std::byte{2};
    write_file(folder.path() / "b.png", compressed);
    Preview broken(codec);
    files.preview(broken);
    CHECK(names_of(broken) == Names{"a.png", "c.png"});
    CHECK(broken.value().at("notes").as_list().size() == 1);
}

TEST_CASE("a page holds videos up to a limit, and says which others there are")
{
    const testing::TemporaryFolder folder;
    const Codec codec;
    Files files;
    files.loaded_from = folder.path();
    files.names = {"a.mp4", "b.webm", "c.mp4", "d.mp4", "e.mp4"};
    for (const std::string& name : files.names)
        write_file(folder.path() / name, std::vector<std::byte>(name == "e.mp4" ? 9'000'000 : 7'000'000));
    Preview page(codec);
    files.preview(page);
    CHECK(names_of(page) == Names{"a.mp4", "b.webm", "c.mp4"});
    CHECK(page.value().at("pictures").as_list()[1].at("uri").as_string().starts_with("data:video/webm;base64,"));
    CHECK(page.value().at("notes") ==
          Value(Value::List{"d.mp4: a video of 7.0 MB is not put into the page, which takes 3.0 MB more; open the file",
                            "e.mp4: a video of 9.0 MB is not put into the page, which takes 8.0 MB at most; open the file"}));
}

TEST_CASE("the last textured mesh shows its atlas and its room, one without texcoords only the atlas")
{
    const Codec codec;
    TexturedMesh room;
    room.image.pixels = Raster8(8, 8, 3);
    room.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    room.mesh.triangles = {{0, 1, 2}};
    Preview without(codec);
    CHECK_THROWS_WITH(room.preview(without), Catch::Contains("no texcoords"));
    CHECK(names_of(without) == Names{"8 × 8 texels"});
    room.mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}};
    Preview page(codec);
    room.preview(page);
    CHECK(page.value().at("room").at("triangles") == Value(1));
    CHECK(page.value().at("room").at("geometry").as_string().size() % 4 == 0);
    CHECK(page.value().at("room").at("texture").as_string().starts_with("data:image/jpeg;base64,"));
    Preview earlier(codec);
    earlier.last = false;
    room.preview(earlier);
    CHECK(earlier.value() == Value(Value::Map{}));
}

TEST_CASE("pictures for a page are small and opaque, and spread evenly")
{
    const Raster8 large = small_copy(Raster8(1000, 500, 3), 100);
    CHECK((large.width == 100 && large.height == 50));
    CHECK(small_copy(Raster8(10, 5, 1), 100) == Raster8(10, 5, 1));
    Raster8 glass(1, 1, 4);
    glass.values = {10, 20, 30, 51};
    CHECK(small_copy(glass, 100).values == std::vector<std::uint8_t>{206, 208, 210});
    CHECK(evenly_spread(5, 12) == std::vector<std::size_t>{0, 1, 2, 3, 4});
    CHECK(evenly_spread(10, 3) == std::vector<std::size_t>{1, 5, 8});
    CHECK(evenly_spread(0, 4).empty());
    const Codec codec;
    Preview nothing(codec);
    Image().preview(nothing);
    CHECK(nothing.value() == Value(Value::Map{}));
    CHECK(has_preview<Image>);
    CHECK_FALSE(has_preview<Table>);
}
