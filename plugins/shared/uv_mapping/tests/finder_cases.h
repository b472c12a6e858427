#pragma once

#include "catch.h"
#include "plain_uv_map.h"
#include "view_cases.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <cmath>
#include <numbers>
#include <numeric>

/// \file What every way of finding the faces that pixels see must pass. A test includes this once and defines:
std::unique_ptr<fresco::FaceFinder> make_finder(const fresco::Mesh& mesh);

namespace
{
using namespace fresco;
using namespace cases;

CountedUvMap one_map(const Mesh& mesh, const Camera& camera, int height_px, const Progress& progress = Progress{})
{
    UvMapper mapper(mesh, make_finder(mesh));
    return mapper.make(camera, std::vector<int>{height_px}, progress).front();
}

std::vector<std::uint32_t> faces_of(const Mesh& mesh, const Camera& camera)
{
    std::vector<FaceMap> faces(1, FaceMap(camera.intrinsics.width, camera.intrinsics.height));
    make_finder(mesh)->find(std::span(&camera, 1), Progress{}, faces);
    return faces.front().values;
}

std::int64_t sum(const PixelCounts& counts)
{
    return counts.valid + counts.back_face + counts.too_near + counts.crack + counts.nothing;
}

/// Equal to the plain map but for `other` pixels at most, whose rays pass an edge within rounding.
void check_against_plain(const Mesh& mesh, const Camera& camera, int height_px, int other)
{
    const UvMap map = one_map(mesh, camera, height_px).map;
    const UvMap plain = plain::uv_map(mesh, camera, height_px);
    int apart = 0;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        const auto near = [&](const RasterF& a, const RasterF& b, std::size_t k, double margin)
        { return std::abs(a.values[k] - b.values[k]) <= margin; };
        const bool same = map.valid.values[i] == plain.valid.values[i] && near(map.uv, plain.uv, 2 * i, 2e-6) &&
                          near(map.uv, plain.uv, 2 * i + 1, 2e-6) && near(map.depth, plain.depth, i, 1e-5) &&
                          near(map.cosine, plain.cosine, i, 1e-5);
        apart += same ? 0 : 1;
    }
    CHECK(apart <= other);
}
}  // namespace

TEST_CASE("back faces, near faces and the void are invalid and counted")
{
    const auto counts = [](double z, double turn = 0)
    {
        const auto [map, counts] = one_map(wall(), testing::camera(8, 6, 10, {0, 0, z}, turn), 6);
        if (counts.valid == 0)
            CHECK((map.valid.values == std::vector<std::uint8_t>(48, 0) && map.depth.values == std::vector<float>(48, 0)));
        return counts;
    };
    CHECK(counts(3, std::numbers::pi).back_face == 48);
    CHECK(counts(1.951).too_near == 48);
    CHECK(counts(1.9999).too_near == 48);
    CHECK(counts(1.949).valid == 48);
    CHECK(counts(3).nothing == 48);
}

TEST_CASE("maps equal those of a test of every face, also where faces cross the camera's plane")
{
    const Mesh mesh = cave(24);
    for (const double angle : {0.0, 0.8, 2.0, 4.4})
    {
        const Camera camera = testing::camera(80, 60, 45, {0.3, -0.2, 0.4}, angle);
        check_against_plain(mesh, camera, 60, 1);
        check_against_plain(mesh, camera, 47, 1);
    }
    check_against_plain(debris(400, 1), testing::camera(80, 60, 45), 60, 8);
    check_against_plain(debris(400, 2), testing::camera(80, 60, 200), 60, 8);
}

TEST_CASE("a pose that is a rotation to four digits only shifts nothing")
{
    Camera camera = testing::camera(400, 300, 250, {0.1, 0.2, -0.3}, 0.7);
    Mat3& r = camera.world_from_camera.rotation;
    r(0, 0) += 1e-4;
    r(1, 2) -= 1e-4;
    r(2, 1) += 2e-4;
    check_against_plain(cave(12), camera, 60, 1);
}

TEST_CASE("no pixel slips between faces whose edges and corners lie on pixel centers")
{
    // Squares, each cut in two by one of its diagonals, whose corners lie on every second pixel center.
    for (Mesh mesh : {testing::rectangle({0, 0, 1}, {0, 2, 0}, {2, 0, 0}, 16, 16),
                      testing::rectangle({2, 0, 1}, {-2, 0, 0}, {0, 2, 0}, 16, 16)})
    {
        mesh.texcoords.assign(3 * mesh.triangles.size(), {0.5F, 0.5F});
        const auto faces = faces_of(mesh, Camera{{30, 30, 16, 16, -1.5, -1.5}, {}});
        CHECK(std::count(faces.begin(), faces.end(), no_face) == 0);
    }
}

TEST_CASE("several faces at one edge, and faces that are there twice, are seen once")
{
    Mesh mesh = wall();
    // Three leaves of a book whose back stands upright in the middle of the picture.
    for (const Vec3f outer : {Vec3f{-0.5F, 0, 1.5F}, {0.1F, 0, 1.8F}, {0.6F, 0, 1.4F}})
        add_face(mesh, {0, -1, 1}, {0, 1, 1}, outer);
    check_against_plain(mesh, testing::camera(60, 60, 41.3), 60, 1);

    // Faces without area, and one whose plane goes through the camera, hide nothing.
    add_face(mesh, {-1, 0, 1}, {0, 0.1F, 1}, {1, 0.2F, 1});
    add_face(mesh, {0.1F, 0.1F, 1}, {0.1F, 0.1F, 1}, {0.1F, 0.1F, 1});
    add_face(mesh, {0, -1, 0.5F}, {0, 1, 0.5F}, {0, 0, 1.5F});
    check_against_plain(mesh, testing::camera(60, 60, 41.3), 60, 1);

    Mesh twice = wall();
    testing::append(twice, wall());
    CHECK(one_map(twice, testing::camera(60, 60, 40), 60).counts.valid == 3600);
}

TEST_CASE("whatever the mesh, every value is finite and every pixel is counted once")
{
    for (unsigned seed = 1; seed <= 6; ++seed)
    {
        Mesh mesh = debris(300, seed);
        for (const float far : {1e6F, 1e18F, 1e30F, 3e38F})
        {
            add_face(mesh, {-far, -far, 3}, {far, -far, 3}, {0, far, 3});
            add_face(mesh, {-1, 0, -far}, {1, 0, far}, {0, 1, far});
        }
        for (const double focal : {5.0, 60.0, 3000.0})
        {
            const auto [map, counts] = one_map(mesh, testing::camera(60, 50, focal, {}, seed), 50);
            CHECK(sum(counts) == 3000);
            CHECK(counts.valid == std::accumulate(map.valid.values.begin(), map.valid.values.end(), std::int64_t{0}));
            bool sound = true;
            for (std::size_t i = 0; i < 3000; ++i)
            {
                const bool valid = map.valid.values[i] == 1;
                sound = sound && std::isfinite(map.uv.values[2 * i]) && std::isfinite(map.uv.values[2 * i + 1]) &&
                        std::isfinite(map.depth.values[i]) && map.cosine.values[i] >= 0 && map.cosine.values[i] <= 1 &&
                        (valid ? map.depth.values[i] >= 0.05F : map.depth.values[i] == 0 && map.uv.values[2 * i] == 0);
            }
            CHECK(sound);
        }
    }
}

TEST_CASE("what is seen through a crack one pixel wide is invalid and counted, what is seen past an edge is not")
{
    // Before the wall four rectangles about a hole of one pixel, (20, 20), and a slit that leads on to the right border: pixels
    // in the slit have neighbors as deep as they.
    const auto boards = [](float hole)
    {
        Mesh mesh = wall();
        add_rectangle(mesh, -0.5F, -0.5F, 0.5F, 0, 1);
        add_rectangle(mesh, -0.5F, hole, 0.5F, 0.5F, 1);
        add_rectangle(mesh, -0.5F, 0, 0, hole, 1);
        return mesh;
    };
    const Camera camera = testing::camera(40, 40, 40);
    Mesh hole = boards(1 / 40.0F);
    add_rectangle(hole, 1 / 40.0F, 0, 0.5F, 1 / 40.0F, 1);
    const auto closed = one_map(hole, camera, 40);
    CHECK(closed.counts.crack == 1);
    CHECK(closed.counts.valid == 1599);
    CHECK(closed.map.valid.at(20, 20) == 0);
    CHECK(closed.map.depth.at(20, 20) == 0);
    CHECK(closed.map.depth.at(21, 20) == Approx(1));

    const auto slit = one_map(boards(1 / 40.0F), camera, 40);
    CHECK(slit.counts.crack == 0);
    CHECK(slit.map.depth.at(20, 20) == Approx(2));
}

TEST_CASE("maps are equal for any number of threads and in any company")
{
    const Mesh mesh = cave(100);  // More faces than a block has.
    const Camera camera = testing::camera(200, 150, 90, {0.1, 0.2, 0.3}, 0.7);
    const std::vector<int> heights{40, 150, 333};
    UvMapper one(mesh, make_finder(mesh));
    UvMapper many(mesh, make_finder(mesh));
    many.make(testing::camera(64, 64, 20), std::vector<int>{333, 40}, testing::TestRun(3));  // leaves its memory to the next
    const auto& a = one.make(camera, heights, testing::TestRun(1));
    const auto& b = many.make(camera, heights, testing::TestRun(5));
    for (std::size_t i = 0; i < heights.size(); ++i)
    {
        const auto alone = one_map(mesh, camera, heights[i]);
        for (const auto* other : {&b[i], &alone})
        {
            CHECK(a[i].map.uv == other->map.uv);
            CHECK(a[i].map.depth == other->map.depth);
            CHECK(a[i].map.cosine == other->map.cosine);
            CHECK(a[i].map.valid == other->map.valid);
            CHECK(a[i].counts == other->counts);
        }
    }
}
