#include "catch.h"

#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

using namespace fresco;

namespace
{

double area_of(const Mesh& mesh)
{
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        area += length(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a])) / 2;
    return area;
}

}  // namespace

TEST_CASE("scenes have the measures that their comments state")
{
    const Mesh box = testing::box({1, 2, 3}, {2, 3, 4});
    CHECK(area_of(box) == Approx(2 * (6 + 8 + 12)));
    const auto normals = face_normals(box);
    for (std::size_t face = 0; face < normals.size(); ++face)
        CHECK(dot(normals[face], box.positions[box.triangles[face][0]] - Vec3f{2, 3.5F, 5}) > 0);
    const Mesh room = testing::room({4, 3, 2.5F}, 2);
    CHECK_NOTHROW(check_mesh(room, "room"));
    CHECK(area_of(room) == Approx(2 * (12 + 10 + 7.5)));
    CHECK(room.triangles.size() == 6 * 8);
    CHECK(room.charts.back() == 5);
    CHECK(area_of(testing::grid(4, [](float, float) { return 1.0F; })) == Approx(1));
    CHECK(area_of(testing::two_chart_wall()) == Approx(2));
    // Inside the room, every ray meets a front.
    const Camera inside = testing::camera(8, 6, 4, {2, 1.5, 1}, 0.3);
    const auto hit = testing::cast(room, inside.world_from_camera.translation, inside.ray(3, 2));
    CHECK((hit.found() && hit.front));
}

TEST_CASE("a recording of a wall shows it where it is")
{
    const testing::TemporaryFolder folder;
    const Frames frames =
        testing::recording_of(testing::wall(), {testing::camera(8, 6, 8), testing::camera(8, 6, 8, {0.5, 0, 1})}, folder.path(),
                              [](Vec3d p, int c) { return c == 0 ? 100 + 50 * p.x : 10.0; });
    REQUIRE(frames.frames.size() == 2);
    CHECK(load_depth(frames.frames[0], nullptr).at(3, 3) == Approx(2));
    CHECK(load_depth(frames.frames[1], nullptr).at(3, 3) == Approx(1));
    // Pixel 4's center is half a pixel right of the axis: 2 m / 16 there.
    CHECK(load_color(frames.frames[0], nullptr).at(4, 3, 0) == 106);
    CHECK(load_color(frames.frames[1], nullptr).at(4, 3, 0) == 128);
    CHECK(load_color(frames.frames[1], nullptr).at(4, 3, 1) == 10);
}
