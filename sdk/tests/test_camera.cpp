#include "catch.h"

#include <fresco/camera.h>
#include <fresco/frames.h>

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
