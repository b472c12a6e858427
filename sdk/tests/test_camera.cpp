#include "catch.h"

#include <fresco/camera.h>
#include <fresco/error.h>
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

TEST_CASE("A pose that is no rotation is refused")
{
    fresco::Camera camera{{64, 48, 50, 50, 32, 24}, {}};
    CHECK_NOTHROW(fresco::check_camera(camera, "pose.txt"));
    camera.world_from_camera.rotation(0, 0) = -1;
    CHECK_THROWS_WITH(fresco::check_camera(camera, "pose.txt"), Contains("pose.txt") && Contains("mirrors"));
    camera.world_from_camera.rotation(0, 0) = 1.1;
    CHECK_THROWS_WITH(fresco::check_camera(camera, "pose.txt"), Contains("not a rotation"));
    camera.world_from_camera.rotation(0, 0) = std::nan("");
    CHECK_THROWS_AS(fresco::check_camera(camera, "pose.txt"), fresco::Error);
}

TEST_CASE("A camera that no lens gives is refused")
{
    const auto check = [](double focal, double center) {
        fresco::check_camera({{64, 48, focal, focal, center, 24}, {}}, "camera.txt");
    };
    CHECK_NOTHROW(check(0.64, 32));
    CHECK_NOTHROW(check(6.4e5, -6.4e5));
    CHECK_THROWS_WITH(check(0.63, 32), Contains("camera.txt: a focal length of 0.63 pixels for a picture of 64x48; from 0.64 to "
                                                "640000.0 are accepted"));
    CHECK_THROWS_WITH(check(6.5e5, 32), Contains("a focal length of 650000.0 pixels"));
    CHECK_THROWS_WITH(check(0.001, 32), Contains("a focal length of 0.001 pixels"));
    CHECK_THROWS_WITH(check(1e300, 32), Contains("a focal length of 1e+300 pixels"));
    CHECK_THROWS_WITH(check(50, -1e30), Contains("camera.txt: the principal point (-1e+30, 24.0)"));
}

TEST_CASE("A pose beyond all rooms is refused")
{
    fresco::Camera camera{{64, 48, 50, 50, 32, 24}, {}};
    camera.world_from_camera.translation.z = -1e7;
    CHECK_NOTHROW(fresco::check_camera(camera, "pose.txt"));
    camera.world_from_camera.translation.z = -1.1e7;
    CHECK_THROWS_WITH(fresco::check_camera(camera, "pose.txt"), Contains("pose.txt: the camera is more than 1e7 m"));
    camera.world_from_camera.translation.z = std::nan("");
    CHECK_THROWS_WITH(fresco::check_camera(camera, "pose.txt"), Contains("pose.txt"));
}
