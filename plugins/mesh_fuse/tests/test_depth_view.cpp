#include "catch.h"
#include "depth_view.h"

#include <cmath>
#include <limits>
#include <numbers>

using namespace fresco;

namespace
{

constexpr int width = 64;
constexpr int height = 48;

Camera camera()
{
    Camera camera;
    camera.intrinsics = {width, height, 60, 61, 31, 25};
    return camera;
}

/// The depth picture of normal · p = offset.
RasterF plane_depth(Vec3d normal, double offset)
{
    RasterF depth(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            depth.at(x, y) = static_cast<float>(offset / dot(normal, camera().ray(x + 0.5, y + 0.5)));
    return depth;
}

std::size_t believed(const fuse::DepthView& view)
{
    std::size_t count = 0;
    for (const fuse::PixelPlane& plane : view.planes.values)
        count += plane.weight > 0 ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("each pixel of a plane finds that plane, and counts by angle and distance")
{
    const Vec3d normal = normalized(Vec3d{0.4, -0.3, -1});
    const RasterF depth = plane_depth(normal, -1.7);
    const fuse::DepthView view = fuse::depth_view(depth, camera(), 5);
    CHECK(believed(view) == static_cast<std::size_t>((width - 2) * (height - 2)));
    for (int y = 1; y + 1 < height; ++y)
        for (int x = 1; x + 1 < width; ++x)
        {
            const fuse::PixelPlane& plane = view.planes.at(x, y);
            CHECK(length(vec_cast<double>(plane.normal) - normal) < 1e-3);
            const Vec3d ray = camera().ray(x + 0.5, y + 0.5);
            const double z = double{depth.at(x, y)};
            CHECK(std::abs(plane.distance(vec_cast<float>(ray * z))) < 1e-5F);
            // A decimeter before it, along the normal.
            CHECK(plane.distance(vec_cast<float>(ray * z + normal * 0.1)) == Approx(0.1).margin(1e-5));
            CHECK(double{plane.weight} == Approx(-dot(normal, normalized(ray)) / (z * z)).epsilon(0.01));
        }
}

TEST_CASE("invalid depth, or depth too far or at the border, is ignored")
{
    RasterF depth(width, height, 1, 2);
    const float infinite = std::numeric_limits<float>::infinity();
    depth.at(20, 20) = 0;
    depth.at(30, 20) = -1;
    depth.at(40, 20) = infinite;
    depth.at(50, 20) = std::numeric_limits<float>::quiet_NaN();
    depth.at(20, 30) = 5.1F;
    const fuse::DepthView view = fuse::depth_view(depth, camera(), 5);
    CHECK(believed(view) == static_cast<std::size_t>((width - 2) * (height - 2) - 5));
    for (const int x : {20, 30, 40, 50})
        CHECK(view.depth.at(x, 20) == 0);
    CHECK(view.depth.at(0, 20) == 0);
    CHECK(view.depth.at(1, 20) == 2);
    CHECK(believed(fuse::depth_view(depth, camera(), 1.9)) == 0);
}

TEST_CASE("pixels beside a depth edge or a hole are not believed, on either side")
{
    RasterF depth(width, height, 1, 2);
    for (int y = 0; y < height; ++y)
    {
        for (int x = 30; x < width; ++x)
            depth.at(x, y) = 2.3F;
        depth.at(10, y) = 0;
    }
    const fuse::DepthView view = fuse::depth_view(depth, camera(), 5);
    for (int y = 1; y + 1 < height; ++y)
        for (int x = 1; x + 1 < width; ++x)
            CHECK((view.depth.at(x, y) > 0) == (std::abs(x - 10) > 1 && x != 29 && x != 30));
    // An edge changes no plane beside it.
    for (const int x : {27, 28, 31, 32})
        CHECK(view.planes.at(x, 20).normal.z < -0.9999F);
}

TEST_CASE("a surface seen along itself is not believed")
{
    Camera narrow = camera();
    narrow.intrinsics.fx = narrow.intrinsics.fy = 600;
    // Through (0, 0, 2), at so many degrees to the optical axis.
    const auto weight = [&](double degrees)
    {
        const double angle = degrees * std::numbers::pi / 180;
        RasterF depth(width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
            {
                const Vec3d ray = narrow.ray(x + 0.5, y + 0.5);
                depth.at(x, y) = static_cast<float>(-2 * std::sin(angle) / (std::cos(angle) * ray.x - std::sin(angle)));
            }
        return fuse::depth_view(depth, narrow, 100).planes.at(31, 24).weight;
    };
    CHECK(weight(14) == Approx(std::sin(14 * std::numbers::pi / 180) / 4).epsilon(0.05));
    CHECK(weight(9) == 0);
}

TEST_CASE("the steps of a sensor do not turn its planes")
{
    // A wall that leans by 30 degrees, in steps of a Kinect's size at its distance.
    const Vec3d normal = normalized(Vec3d{std::tan(0.52), 0, -1});
    RasterF depth = plane_depth(normal, -2.2);
    Camera fine = camera();
    for (float& meters : depth.values)
        meters = 1 / (std::round(1 / meters / 0.0029F) * 0.0029F);
    const fuse::DepthView view = fuse::depth_view(depth, fine, 10);
    double worst = 0;
    for (int y = 5; y + 5 < height; ++y)
        for (int x = 5; x + 5 < width; ++x)
        {
            REQUIRE(view.planes.at(x, y).weight > 0);
            worst = std::max(worst, length(vec_cast<double>(view.planes.at(x, y).normal) - normal));
        }
    CHECK(worst < 0.05);
}
