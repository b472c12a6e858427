#include "uv_map_caster.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace fresco;

namespace
{
/// A wall z = 2 over x, y in [-2,2], facing the origin; uv runs with x and against y (an image's y points down).
Mesh wall()
{
    Mesh mesh;
    mesh.positions = {{-2, -2, 2}, {2, -2, 2}, {2, 2, 2}, {-2, 2, 2}};
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
    mesh.texcoords = {{0, 1}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}};
    return mesh;
}

Camera straight(int width, int height, double focal)
{
    Camera camera;
    camera.intrinsics = {width, height, focal, focal, width / 2.0, height / 2.0};
    return camera;
}

/// Turned about the y axis, so that the wall is seen at a slant.
Camera turned(Camera camera, double angle)
{
    Mat3& r = camera.world_from_camera.rotation;
    r(0, 0) = r(2, 2) = std::cos(angle);
    r(0, 2) = std::sin(angle);
    r(2, 0) = -std::sin(angle);
    return camera;
}
}  // namespace

TEST_CASE("a wall seen from the front has the uv, depth and cosine of plain geometry")
{
    const Mesh mesh = wall();
    const UvMapCaster caster(mesh);
    PixelCounts counts;
    const UvMap map = caster.cast(straight(64, 48, 50), 48, Progress{}, counts);
    REQUIRE(map.uv.width == 64);
    REQUIRE(map.uv.height == 48);
    REQUIRE(map.uv.channels == 2);
    CHECK(counts.valid == 64 * 48);
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
        {
            const double dx = (x + 0.5 - 32) / 50;
            const double dy = (y + 0.5 - 24) / 50;
            REQUIRE(map.valid.at(x, y) == 1);
            CHECK(map.depth.at(x, y) == Approx(2).epsilon(1e-6));
            CHECK(map.uv.at(x, y, 0) == Approx((2 * dx + 2) / 4).epsilon(1e-5));
            CHECK(map.uv.at(x, y, 1) == Approx(1 - (2 * dy + 2) / 4).epsilon(1e-5));
            CHECK(map.cosine.at(x, y) == Approx(1 / std::sqrt(dx * dx + dy * dy + 1)).epsilon(1e-5));
        }
}

TEST_CASE("uv is correct in perspective on a slanted wall and at another height")
{
    const Mesh mesh = wall();
    const UvMapCaster caster(mesh);
    const double angle = 0.5;
    const Camera camera = turned(straight(64, 48, 50), angle);
    PixelCounts counts;
    const UvMap map = caster.cast(camera, 36, Progress{}, counts);
    REQUIRE(map.uv.width == 48);
    int checked = 0;
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 48; ++x)
        {
            const double dx = ((x + 0.5) * 4 / 3 - 32) / 50;
            const double dy = ((y + 0.5) * 4 / 3 - 24) / 50;
            const double world_x = std::cos(angle) * dx + std::sin(angle);
            const double world_z = -std::sin(angle) * dx + std::cos(angle);
            const double depth = 2 / world_z;
            const double px = depth * world_x;
            const double py = depth * dy;
            if (std::abs(px) > 1.999 || std::abs(py) > 1.999)
                continue;
            ++checked;
            CHECK(map.depth.at(x, y) == Approx(depth).epsilon(1e-5));
            CHECK(map.uv.at(x, y, 0) == Approx((px + 2) / 4).margin(1e-5));
            CHECK(map.uv.at(x, y, 1) == Approx(1 - (py + 2) / 4).margin(1e-5));
            CHECK(map.cosine.at(x, y) == Approx(world_z / std::sqrt(dx * dx + dy * dy + 1)).epsilon(1e-5));
        }
    CHECK(checked > 1000);
    CHECK(counts.nothing > 0);
    CHECK(counts.valid + counts.nothing == 36 * 48);
}

TEST_CASE("a map scales each axis on its own")
{
    // 100 x 75 at height 10 is 13 wide: 13/100 against 10/75.
    const Mesh mesh = wall();
    const UvMapCaster caster(mesh);
    PixelCounts counts;
    const UvMap map = caster.cast(straight(100, 75, 80), 10, Progress{}, counts);
    REQUIRE(map.uv.width == 13);
    const double dx = ((0.5 / 13) * 100 - 50) / 80;
    const double dy = ((0.5 / 10) * 75 - 37.5) / 80;
    CHECK(map.uv.at(0, 0, 0) == Approx((2 * dx + 2) / 4).epsilon(1e-5));
    CHECK(map.uv.at(0, 0, 1) == Approx(1 - (2 * dy + 2) / 4).epsilon(1e-5));
}

TEST_CASE("back faces, near faces and the void are invalid and counted")
{
    const Mesh mesh = wall();
    const UvMapCaster caster(mesh);
    PixelCounts counts;
    Camera behind = straight(8, 6, 10);
    behind.world_from_camera.translation = {0, 0, 3};
    behind.world_from_camera.rotation.m = {-1, 0, 0, 0, 1, 0, 0, 0, -1};  // looks back along -z
    UvMap map = caster.cast(behind, 6, Progress{}, counts);
    CHECK(counts.back_face == 48);
    CHECK(counts.valid == 0);
    CHECK(map.valid.values == std::vector<std::uint8_t>(48, 0));
    CHECK(map.depth.values == std::vector<float>(48, 0));

    Camera near = straight(8, 6, 10);
    near.world_from_camera.translation = {0, 0, 1.951};
    map = caster.cast(near, 6, Progress{}, counts);
    CHECK(counts.too_near == 48);
    near.world_from_camera.translation = {0, 0, 1.949};
    map = caster.cast(near, 6, Progress{}, counts);
    CHECK(counts.valid == 48);

    Camera away = straight(8, 6, 10);
    away.world_from_camera.translation = {0, 0, 3};
    map = caster.cast(away, 6, Progress{}, counts);
    CHECK(counts.nothing == 48);
}

TEST_CASE("the nearer of two walls hides the other, and normals are smooth")
{
    Mesh mesh = wall();
    // A small wall at z = 1 before it, bent: the normals of its middle vertices lean.
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3f p : {Vec3f{-0.2F, -0.2F, 1}, {0.2F, -0.2F, 1}, {0.2F, 0.2F, 1}, {-0.2F, 0.2F, 1}})
        mesh.positions.push_back(p);
    mesh.triangles.push_back({first, first + 2, first + 1});
    mesh.triangles.push_back({first, first + 3, first + 2});
    for (int i = 0; i < 6; ++i)
        mesh.texcoords.push_back({0.25F, 0.75F});
    const UvMapCaster caster(mesh);
    PixelCounts counts;
    const UvMap map = caster.cast(straight(40, 40, 40), 40, Progress{}, counts);
    CHECK(map.depth.at(20, 20) == Approx(1));
    CHECK(map.uv.at(20, 20, 0) == 0.25F);
    CHECK(map.depth.at(2, 2) == Approx(2));
    int small = 0;
    for (const float depth : map.depth.values)
        small += depth < 1.5F;
    CHECK(small == 16 * 16);
}

TEST_CASE("the cosine comes from area-weighted vertex normals")
{
    // A ridge: the faces lean by 45 degrees to both sides, the edge's vertices get the mean normal (0,0,-1).
    Mesh mesh;
    mesh.positions = {{0, -1, 1}, {0, 1, 1}, {-1, 0, 2}, {1, 0, 2}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}};
    mesh.texcoords.assign(6, {0.5F, 0.5F});
    const UvMapCaster caster(mesh);
    PixelCounts counts;
    const UvMap map = caster.cast(straight(201, 101, 1000), 101, Progress{}, counts);
    REQUIRE(map.valid.at(100, 50) == 1);
    CHECK(map.cosine.at(100, 50) == Approx(1).epsilon(1e-3));        // on the edge: smooth
    CHECK(map.cosine.at(100, 50) > std::cos(0.7));                   // a flat normal would give cos 45 degrees
    CHECK(map.cosine.at(200, 50) < map.cosine.at(100, 50) - 1e-3F);  // and it bends towards the sides
}

TEST_CASE("maps are equal for any number of threads")
{
    struct Threads final : Progress
    {
        explicit Threads(int n) : n_(n) {}
        int threads() const override { return n_; }
        int n_;
    };
    const Mesh mesh = wall();
    const UvMapCaster caster(mesh);
    PixelCounts one;
    PixelCounts many;
    const Camera camera = turned(straight(100, 75, 40), 0.7);
    const UvMap a = caster.cast(camera, 150, Threads(1), one);
    const UvMap b = caster.cast(camera, 150, Threads(5), many);
    CHECK(a.uv == b.uv);
    CHECK(a.depth == b.depth);
    CHECK(a.cosine == b.cosine);
    CHECK(a.valid == b.valid);
    CHECK(one.valid == many.valid);
}
