#include "catch.h"

#include <fresco/camera.h>
#include <fresco/frames.h>

using Catch::Contains;

TEST_CASE("A camera projects along its own rays")
{
    fresco::Camera camera{{640, 480, 528, 520, 320, 238}, {{{0, -1, 0, 1, 0, 0, 0, 0, 1}}, {1, 2, 3}}};
    const fresco::Vec3d p = camera.world_from_camera.translation + camera.ray(100.5, 50.5) * 2.0;
    const fresco::Vec3d seen = camera.project(p);
    CHECK(seen.x == Approx(100.5));
    CHECK(seen.y == Approx(50.5));
    CHECK(seen.z == Approx(2));
    // x of the camera points along y of the world here.
    CHECK(camera.project({1, 2 + 0.5, 3 + 1}).x == Approx(320 + 528 * 0.5));
    const auto small = camera.intrinsics.scaled_to(341, 256);
    CHECK(small.fx == Approx(528 * 341 / 640.0));
    CHECK(small.cy == Approx(238 * 256 / 480.0));
    CHECK(camera.intrinsics.width_at(256) == 341);
    const auto back = camera.world_from_camera * camera.world_from_camera.inverse();
    CHECK(back.rotation_error() < 1e-12);
    CHECK(fresco::length(back.translation) < 1e-12);
}

TEST_CASE("A camera that cannot be is refused by file and reason, and the limits are accepted")
{
    const auto check = [](const auto& change)
    {
        fresco::Camera camera{{64, 48, 50, 50, 32, 24}, {}};
        change(camera);
        fresco::check_camera(camera, "pose.txt");
    };
    const auto refused = [&](const auto& change, const std::string& word)
    { CHECK_THROWS_WITH(check(change), Contains("pose.txt: ") && Contains(word)); };
    const auto turned = [](double m) { return [m](fresco::Camera& c) { c.world_from_camera.rotation(0, 0) = m; }; };
    const auto at = [](double z) { return [z](fresco::Camera& c) { c.world_from_camera.translation.z = z; }; };
    const auto lens = [](double focal, double center)
    { return [=](fresco::Camera& c) { c.intrinsics = {64, 48, focal, focal, center, 24}; }; };
    CHECK_NOTHROW(check(turned(1)));
    refused(turned(-1), "mirrors");
    refused(turned(1.1), "not a rotation");
    refused(turned(std::nan("")), "");
    CHECK_NOTHROW(check(at(-1e7)));
    refused(at(-1.1e7), "1e7 m");
    refused(at(std::nan("")), "");
    CHECK_NOTHROW(check(lens(0.64, 32)));
    CHECK_NOTHROW(check(lens(6.4e5, -6.4e5)));
    for (const double focal : {0.63, 6.5e5, 1e300})
        refused(lens(focal, 32), "focal length");
    refused(lens(50, -1e30), "principal point");
}
