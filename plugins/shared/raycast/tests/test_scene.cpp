#include "catch.h"

#include <fresco/random.h>
#include <fresco/raycast/scene.h>
#include <fresco/testing_scenes.h>

#include <cmath>
#include <utility>

using namespace fresco;
using namespace fresco::raycast;

namespace
{
/// A bumpy sheet z = 2 + 0.3 sin(3x) cos(2y) over [-1,1]^2, seen from the origin side.
Mesh sheet(std::uint32_t cells)
{
    const auto z = [](float u, float v) { return 2 + 0.3F * std::sin(3 * (2 * u - 1)) * std::cos(2 * (2 * v - 1)); };
    Mesh mesh = testing::grid(cells, z);
    for (Vec3f& p : mesh.positions)
        p = {2 * p.x - 1, 2 * p.y - 1, p.z};
    for (Triangle& t : mesh.triangles)
        std::swap(t[1], t[2]);
    return mesh;
}

}  // namespace

TEST_CASE("packets agree with every triangle tried in turn")
{
    const Mesh mesh = sheet(12);
    const Scene scene(mesh);
    const Camera view = testing::camera(37, 22, 29.6, {0.1, -0.05, 0.013});  // not a multiple of the packet's side
    std::vector<Hit> hits(37 * 22);
    scene.cast_rows(view, 0, 10, std::span(hits).first(37 * 10));
    scene.cast_rows(view, 10, 22, std::span(hits).subspan(37 * 10));
    int found = 0;
    for (int y = 0; y < 22; ++y)
        for (int x = 0; x < 37; ++x)
        {
            const Hit& fast = hits[static_cast<std::size_t>(y * 37 + x)];
            const auto slow = testing::cast(mesh, view.world_from_camera.translation, view.ray(x + 0.5, y + 0.5));
            REQUIRE(fast.found() == slow.found());
            if (!fast.found())
                continue;
            ++found;
            CHECK(fast.distance == Approx(slow.distance).epsilon(1e-7));
            CHECK(fast.front);
            const auto p = corners(mesh, fast.triangle);
            const Vec3d point = p[0] * fast.weights[0] + p[1] * fast.weights[1] + p[2] * fast.weights[2];
            const Vec3d expected = view.world_from_camera.translation + view.ray(x + 0.5, y + 0.5) * fast.distance;
            CHECK(length(point - expected) < 1e-6);
        }
    CHECK(found > 300);
}

TEST_CASE("a hit is judged by side and depth")
{
    Mesh mesh;
    mesh.positions = {{-1, -1, 1}, {-1, 1, 1}, {1, -1, 1}};
    mesh.triangles = {{0, 1, 2}};
    const Scene scene(mesh);
    const auto look = [&](Vec3d from, Vec3d direction)
    {
        Hit hit;
        scene.cast(from, std::span(&direction, 1), std::span(&hit, 1));
        return sight(hit);
    };
    CHECK(look({-0.5, -0.5, 0}, {0, 0, 1}) == Sight::surface);
    CHECK(look({-0.5, -0.5, 2}, {0, 0, -1}) == Sight::back_face);
    CHECK(look({-0.5, -0.5, 0.96}, {0, 0, 1}) == Sight::too_near);
    CHECK(look({-0.5, -0.5, 0.94}, {0, 0, 1}) == Sight::surface);
    CHECK(look({0.5, 0.5, 0}, {0, 0, 1}) == Sight::nothing);
}

TEST_CASE("texels between neighboring pixels follow distance, tilt and the picture's size")
{
    // A square of side 2 at z = 2 whose texcoords span the picture: 1 m is half of it.
    Mesh mesh;
    mesh.positions = {{-1, -1, 2}, {1, -1, 2}, {-1, 1, 2}};
    mesh.triangles = {{0, 2, 1}};
    mesh.texcoords = {{0, 1}, {0, 0}, {1, 1}};
    Camera camera = testing::camera(100, 100, 50);  // a pixel is 1/50 of the depth: 4 cm
    CHECK(texels_per_pixel(mesh, 0, {0.5, 0.5}, camera, 50, 50, 100, 100) == Approx(2));
    CHECK(texels_per_pixel(mesh, 0, {0.5, 0.5}, camera, 50, 50, 300, 100) == Approx(6));
    CHECK(texels_per_pixel(mesh, 0, {0.5, 0.5}, camera, 50, 50, 100, 300) == Approx(6));
    camera.world_from_camera.translation = {0, 0, 1};
    CHECK(texels_per_pixel(mesh, 0, {0.5, 0.5}, camera, 50, 50, 100, 100) == Approx(1));
    camera.world_from_camera.translation = {0, 0, 3};  // the plane is behind
    CHECK(texels_per_pixel(mesh, 0, {0.5, 0.5}, camera, 50, 50, 100, 100) == 0);
}
