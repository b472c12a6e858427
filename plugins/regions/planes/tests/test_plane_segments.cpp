#include "catch.h"
#include "plane_segments.h"
#include "rooms.h"

using namespace fresco;

namespace
{

std::vector<PlaneSegment> segments_of(const Mesh& mesh)
{
    return plane_segments(SmoothSurface(mesh, Progress{}), Progress{});
}

}  // namespace

TEST_CASE("plane segments: a noisy plane is one piece, fitted by least squares")
{
    KnownRoom room;
    room.noise_m = 0.005;
    room.sheet(RoomPart::floor, {0, 0, 1}, {3, 0, 0.2F}, {0, 2, 0.1F});
    const auto segments = segments_of(room.mesh);
    REQUIRE(!segments.empty());
    const auto& largest = *std::ranges::max_element(segments, {}, &PlaneSegment::area);
    CHECK(static_cast<double>(largest.faces.size()) > 0.97 * static_cast<double>(room.parts.size()));
    CHECK(dot(largest.normal, normalized(cross(Vec3d{3, 0, 0.2}, Vec3d{0, 2, 0.1}))) > std::cos(0.01));
    CHECK(largest.distance({1.5, 1, 1.15}) == Approx(0).margin(0.003));
}

TEST_CASE("plane segments: a step of 10 cm parts two planes, faces without area are in none")
{
    KnownRoom room;
    room.sheet(RoomPart::floor, {}, {1, 0, 0}, {0, 1, 0});
    room.sheet(RoomPart::floor, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.1F});
    room.sheet(RoomPart::floor, {1, 0, 0.1F}, {1, 0, 0}, {0, 1, 0});
    room.mesh.triangles.push_back({0, 1, 1});
    const auto segments = segments_of(room.mesh);
    CHECK(std::ranges::count_if(segments, [](const PlaneSegment& s) { return s.normal.z > 0.99 && s.area > 0.9; }) == 2);
    for (const PlaneSegment& segment : segments)
        CHECK(std::ranges::find(segment.faces, room.mesh.triangles.size() - 1) == segment.faces.end());
}
