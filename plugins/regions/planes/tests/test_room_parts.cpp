#include "catch.h"
#include "rooms.h"

#include "plane_segments.h"
#include "room_parts.h"
#include "room_picture.h"

#include <fresco/testing.h>
#include <fresco/texturing/texel_faces.h>

#include <map>
#include <numeric>
#include <set>
#include <span>

using namespace fresco;

namespace
{

RoomParts found(const KnownRoom& room)
{
    return find_room_parts(room.mesh, Progress{});
}

/// 5 x 4 x 2.5 m with a table, a cupboard before a wall, a counter along another, and a rug, picture and door that are thinner
/// than 6 cm.
KnownRoom furnished(double noise_m = 0, bool with_ceiling = true)
{
    KnownRoom room;
    room.noise_m = noise_m;
    room.shell({5, 4, 2.5F}, with_ceiling);
    room.table(1.8F, 1.5F);
    room.block({0.3F, 3.4F, 0}, {1.2F, 0.6F, 1.9F});
    room.block({4.4F, 0.5F, 0}, {0.6F, 2.5F, 0.9F});
    room.block({1.0F, 0.3F, 0}, {2.2F, 1.0F, 0.015F}, RoomPart::floor);
    room.block({2.0F, 3.96F, 1.2F}, {0.9F, 0.04F, 0.6F}, RoomPart::walls);
    room.block({3.5F, 3.97F, 0}, {0.9F, 0.03F, 2.0F}, RoomPart::walls);
    return room;
}

}  // namespace

TEST_CASE("room parts: floor, ceiling and walls of a furnished room, with and without noise")
{
    for (const double noise_m : {0.0, 0.004})
    {
        const KnownRoom room = furnished(noise_m);
        const RoomParts parts = found(room);
        CHECK(room.least_iou(parts.of_face) > 0.95);
        REQUIRE(parts.floor_heights_m.size() == 1);
        CHECK(parts.floor_heights_m[0] == Approx(0).margin(0.02));
        REQUIRE(parts.ceiling_heights_m.size() == 2);
        CHECK(parts.ceiling_heights_m[0] == Approx(2.5).margin(0.01));
    }
}

TEST_CASE("room parts: without a ceiling walls are what is tall and has nothing taller behind it")
{
    const KnownRoom room = furnished(0.004, false);
    const RoomParts parts = found(room);
    CHECK(parts.ceiling_heights_m.empty());
    CHECK(room.iou(parts.of_face, RoomPart::floor) > 0.95);
    CHECK(room.iou(parts.of_face, RoomPart::walls) > 0.95);
    CHECK(room.iou(parts.of_face, RoomPart::furniture) > 0.9);
}

TEST_CASE(
    "room parts: a strip of wall between a counter and cupboards is one, though nothing above was scanned; a sideboard is not")
{
    KnownRoom room;
    room.noise_m = 0.004;
    const Vec3f up{0, 0, 0.48F}, across{0, 3, 0};
    room.sheet(RoomPart::floor, {}, {4, 0, 0}, across);
    room.sheet(RoomPart::walls, {4, 3, 0}, {0, 0, 1.65F}, {-4, 0, 0});
    // An appliance on the counter parts the strip; the larger part is bent by 1.5 degrees.
    room.sheet(RoomPart::walls, {0, 0.7F, 0.92F}, up, {0, -0.7F, 0});
    room.sheet(RoomPart::walls, {-0.055F, 3, 0.92F}, up, {0.055F, -2.1F, 0});
    room.sheet(RoomPart::furniture, {0, 0.7F, 0.92F}, {0.4F, 0, 0}, up);
    room.sheet(RoomPart::furniture, {0.4F, 0.7F, 0.92F}, {0, 0.2F, 0}, up);
    room.sheet(RoomPart::furniture, {0, 0.9F, 0.92F}, up, {0.4F, 0, 0});
    room.sheet(RoomPart::furniture, {0, 0, 0.92F}, {0.6F, 0, 0}, across);
    room.sheet(RoomPart::furniture, {0.6F, 0, 0}, across, {0, 0, 0.92F});
    room.sheet(RoomPart::furniture, {0, 0, 1.4F}, across, {0.35F, 0, 0});
    room.sheet(RoomPart::furniture, {0.35F, 0, 1.4F}, across, {0, 0, 0.25F});
    // A sideboard, behind and above which nothing was scanned.
    room.sheet(RoomPart::furniture, {3.5F, 0.5F, 0}, {0, 0, 1.2F}, {0, 2, 0});
    room.sheet(RoomPart::furniture, {3.5F, 0.5F, 1.2F}, {0.4F, 0, 0}, {0, 2, 0});
    CHECK(room.least_iou(found(room).of_face) > 0.98);
}

TEST_CASE("room parts: large connected furniture is numbered by area, and the report's picture shows the numbers")
{
    KnownRoom room;
    room.shell({4, 3, 2.4F});
    room.block({2.5F, 0.6F, 0}, {0.6F, 0.6F, 0.6F});
    room.block({0.6F, 1, 0}, {1.2F, 0.6F, 0.9F});
    room.block({3.6F, 2.6F, 0}, {0.2F, 0.2F, 0.2F});
    const RoomParts parts = found(room);
    REQUIRE(parts.furniture_count == 2);
    // The slow twin: each furniture face takes the least number along its edges, until nothing changes.
    const Mesh mesh = texturing::welded(room.mesh);
    std::vector<std::size_t> least(mesh.triangles.size());
    std::iota(least.begin(), least.end(), std::size_t{0});
    for (bool changed = true; changed;)
    {
        changed = false;
        geometry::for_each_edge(mesh.triangles, mesh.positions.size(),
                                [&](std::uint32_t, std::uint32_t, std::span<const geometry::EdgeUse> uses)
                                {
                                    for (const auto& a : uses)
                                        for (const auto& b : uses)
                                            if (parts.of_face[a.face] == RoomPart::furniture &&
                                                parts.of_face[b.face] == RoomPart::furniture && least[a.face] < least[b.face])
                                            {
                                                least[b.face] = least[a.face];
                                                changed = true;
                                            }
                                });
    }
    std::map<std::size_t, double> areas;
    std::map<std::size_t, std::set<std::size_t>> numbers;
    for (std::size_t f = 0; f < least.size(); ++f)
    {
        CHECK((parts.of_face[f] == RoomPart::furniture || parts.furniture_of_face[f] == 0));
        if (parts.of_face[f] != RoomPart::furniture)
            continue;
        areas[least[f]] += length(geometry::area_vector(mesh, f)) / 2;
        numbers[least[f]].insert(parts.furniture_of_face[f]);
    }
    std::map<std::size_t, double> area_of_number;
    for (const auto& [piece, area] : areas)
    {
        REQUIRE(numbers[piece].size() == 1);
        const std::size_t number = *numbers[piece].begin();
        CHECK((number == 0) == (area < least_furniture_m2));
        area_of_number[number] += number > 0 ? area : 0;
    }
    CHECK(area_of_number[1] == Approx(1.2 * 0.6 + 1.2 * 0.9 + 2 * 0.6 * 0.9).epsilon(0.1));
    CHECK(area_of_number[2] == Approx(4 * 0.6 * 0.6).epsilon(0.1));

    testing::TestRun one(1);
    const Raster8 picture = room_picture(room.mesh, parts, one);
    std::array<std::size_t, 2> colored{};
    std::size_t ink = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
        {
            const std::span rgb(&picture.at(x, y), 3);
            colored[static_cast<std::size_t>(2 * y / picture.height)] += rgb[0] != rgb[1] || rgb[1] != rgb[2] ? 1 : 0;
            ink += std::ranges::count(rgb, 0) == 3 ? 1 : 0;
        }
    // A "1" has 8 squares of 3 x 3 pixels, a "2" 11; both are seen from both sides.
    CHECK(ink == 2 * (8 + 11) * 9);
    CHECK(colored[0] > 2000);
    CHECK(colored[1] > 2000);
    testing::TestRun many(5);
    CHECK(room_picture(room.mesh, parts, many) == picture);
}

TEST_CASE("room parts: holes change nothing around them")
{
    KnownRoom room = furnished(0.004);
    std::vector<Triangle> triangles;
    std::vector<RoomPart> parts;
    for (std::size_t f = 0; f < room.parts.size(); ++f)
    {
        // Balls of 30 cm, one in each cubic meter.
        const Vec3d at = face_middle(room.mesh, f);
        const auto part = [](double v) { return v - std::floor(v) - 0.5; };
        if (length(Vec3d{part(at.x), part(at.y), part(at.z)}) < 0.3)
            continue;
        triangles.push_back(room.mesh.triangles[f]);
        parts.push_back(room.parts[f]);
    }
    room.mesh.triangles = triangles;
    room.parts = parts;
    CHECK(room.least_iou(found(room).of_face) > 0.93);
}

TEST_CASE("room parts: a slanted ceiling is one, down to its knee walls")
{
    KnownRoom room;
    const Vec3f along{0, 4, 0};
    room.sheet(RoomPart::floor, {}, {5, 0, 0}, along);
    room.sheet(RoomPart::walls, {}, along, {0, 0, 0.9F});
    room.sheet(RoomPart::walls, {5, 0, 0}, {0, 0, 0.9F}, along);
    room.sheet(RoomPart::ceiling, {0, 0, 0.9F}, along, {2.5F, 0, 2});
    room.sheet(RoomPart::ceiling, {5, 0, 0.9F}, {-2.5F, 0, 2}, along);
    const RoomParts parts = found(room);
    CHECK(room.iou(parts.of_face, RoomPart::floor) > 0.97);
    CHECK(room.iou(parts.of_face, RoomPart::ceiling) > 0.97);
    CHECK(room.iou(parts.of_face, RoomPart::walls) > 0.95);
}

TEST_CASE("room parts: two storeys and a raised floor are floors, a bed is not")
{
    KnownRoom room;
    room.shell({6, 5, 2.4F});
    room.sheet(RoomPart::floor, {3.4F, 0, 0.3F}, {2.6F, 0, 0}, {0, 5, 0});
    room.sheet(RoomPart::furniture, {3.4F, 5, 0}, {0, -5, 0}, {0, 0, 0.3F});
    room.block({0.5F, 0.5F, 0}, {2, 1.6F, 0.5F});
    KnownRoom upper;
    upper.shell({6, 5, 2.4F});
    for (Vec3f& p : upper.mesh.positions)
        p.z += 2.7F;
    testing::append(room.mesh, upper.mesh);
    room.parts.insert(room.parts.end(), upper.parts.begin(), upper.parts.end());
    const RoomParts parts = found(room);
    REQUIRE(parts.floor_heights_m.size() == 3);
    CHECK(parts.floor_heights_m[1] == Approx(0.3).margin(0.01));
    CHECK(parts.floor_heights_m[2] == Approx(2.7).margin(0.01));
    CHECK(room.iou(parts.of_face, RoomPart::floor) > 0.95);
    CHECK(room.iou(parts.of_face, RoomPart::ceiling) > 0.97);
    CHECK(room.iou(parts.of_face, RoomPart::furniture) > 0.9);
}

TEST_CASE("room parts: equal for a mesh cut along seams")
{
    const KnownRoom room = furnished(0.004);
    Mesh cut;
    for (const Triangle& triangle : room.mesh.triangles)
    {
        const auto first = static_cast<std::uint32_t>(cut.positions.size());
        for (const std::uint32_t corner : triangle)
            cut.positions.push_back(room.mesh.positions[corner]);
        cut.triangles.push_back({first, first + 1, first + 2});
    }
    const Progress run;
    CHECK(find_room_parts(cut, run).of_face == find_room_parts(room.mesh, run).of_face);
}
