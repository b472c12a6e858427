#include "catch.h"
#include "packed_mesh.h"

#include <fresco/page/page.h>
#include <fresco/testing_scenes.h>

#include <cmath>
#include <cstdint>
#include <set>

using namespace fresco;
using namespace fresco::page;

namespace
{

struct Unpacked
{
    std::vector<std::array<int, 5>> values;
    std::vector<std::size_t> corners;
};

/// As the page does it.
Unpacked unpacked(const PackedMesh& room)
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
    const PackedMesh room = pack_mesh(mesh);
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
    constexpr std::uint32_t side = 60;
    Mesh mesh = testing::rectangle({}, {side, 0, 0}, {0, side, 0}, side, side);
    for (Vec3f& p : mesh.positions)
        p.z = static_cast<float>(std::lround(p.x * p.y) % 7);
    const auto ordered = mesh.triangles;
    for (std::uint32_t face = 0; face < ordered.size(); ++face)
        mesh.triangles[face] = ordered[face * 1009U % ordered.size()];  // Coprime: every face once.
    mesh.triangles.push_back(mesh.triangles.front());                   // A face twice, and an edge of more than two faces.
    mesh.triangles.push_back({0, 1, 5});
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x / side, p.y / side}; });
    const PackedMesh room = pack_mesh(mesh);
    CHECK(room.bytes.size() <= 12 * room.vertices + 4 * room.triangles);
    const Unpacked found = unpacked(room);
    REQUIRE(found.values.size() == mesh.positions.size());
    std::multiset<std::array<long, 9>> expected, faces;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        std::array<long, 9> meant{}, seen{};
        for (std::size_t i = 0; i < 9; ++i)
        {
            const Vec3f p = mesh.positions[mesh.triangles[face][i / 3]];
            meant[i] = std::lround(std::array{p.x, p.y, p.z}[i % 3]);
            seen[i] =
                std::lround(room.low[i % 3] + found.values[found.corners[3 * face + i / 3]][i % 3] * room.extent[i % 3] / 65535);
        }
        expected.insert(meant);
        faces.insert(seen);
    }
    CHECK(faces == expected);
}

TEST_CASE("data URIs give the test vectors of RFC 4648")
{
    const auto encoded = [](std::string_view text) { return data_uri("text/plain", std::as_bytes(std::span(text))); };
    const std::string begin = "data:text/plain;base64,";
    for (const auto& [text, expected] : {std::pair{"", ""},
                                         {"f", "Zg=="},
                                         {"fo", "Zm8="},
                                         {"foo", "Zm9v"},
                                         {"fooba", "Zm9vYmE="},
                                         {"foobar", "Zm9vYmFy"},
                                         {"\xfb\xff\xfe", "+//+"}})
        CHECK(encoded(text) == begin + expected);
}

TEST_CASE("pictures for a page are small and opaque")
{
    const Raster8 large = small_copy(Raster8(1000, 500, 3), 100);
    CHECK((large.width == 100 && large.height == 50));
    CHECK(small_copy(Raster8(10, 5, 1), 100) == Raster8(10, 5, 1));
    Raster8 glass(1, 1, 4);
    glass.values = {10, 20, 30, 51};
    CHECK(small_copy(glass, 100).values == std::vector<std::uint8_t>{206, 208, 210});
}
