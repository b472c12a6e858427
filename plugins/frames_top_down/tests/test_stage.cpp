#include "catch.h"

#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <cmath>

using namespace fresco;

TEST_CASE("the whole mesh is in the picture, its longer side across, right side up and not mirrored")
{
    // A floor of 4 m x 2 m, turned by 30 degrees about z, which is up, with a post at one corner.
    const auto mesh = std::make_shared<Mesh>();
    const auto at = [](double x, double y, double z)
    {
        const double c = std::cos(0.5236);
        const double s = std::sin(0.5236);
        return Vec3f{static_cast<float>(7 + c * x - s * y), static_cast<float>(s * x + c * y), static_cast<float>(z)};
    };
    mesh->positions = {at(0, 0, 1), at(4, 0, 1), at(4, 2, 1), at(0, 2, 1), at(0, 0, 1.5), at(0.1, 0, 1.5), at(0, 0.1, 1.5)};
    mesh->triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}};
    const testing::TemporaryFolder folder;
    testing::TestRun run;
    testing::run_stage(FRESCO_PLUGIN_FILE, "frames.top_down", Value::Map{{"height_px", 200}, {"up", "z"}}, {{"mesh", mesh}},
                       folder.path(), run);
    const auto frames = Frames::load({folder.path() / "frames", {}});
    REQUIRE(frames->frames.size() == 1);
    const Camera& camera = frames->frames[0].color;
    check_camera(camera, "the camera");
    CHECK(camera.intrinsics.width == Approx(400).margin(12));
    double left = 1e9;
    double right = 0;
    for (const Vec3f position : mesh->positions)
    {
        const Vec3d seen = camera.project(vec_cast<double>(position));
        CHECK((seen.x > 0 && seen.y > 0 && seen.x < camera.intrinsics.width && seen.y < camera.intrinsics.height && seen.z > 0));
        left = std::min(left, seen.x);
        right = std::max(right, seen.x);
    }
    CHECK(right - left > 0.8 * camera.intrinsics.width);
    // Counterclockwise from above, as the corners run, is counterclockwise in the picture, whose y points down.
    const auto a = camera.project(vec_cast<double>(mesh->positions[0]));
    const auto b = camera.project(vec_cast<double>(mesh->positions[1]));
    const auto c = camera.project(vec_cast<double>(mesh->positions[2]));
    CHECK((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) < 0);
}
