#include "catch.h"
#include "view_cases.h"

#include <fresco/error.h>
#include <fresco/rendering/raster_finder.h>
#include <fresco/testing.h>
#include <fresco/uv_mapping/shading.h>
#include <fresco/uv_mapping/uv_mapper.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

/// \file Uv maps of the faces that RasterFinder finds.

using namespace fresco;
using namespace cases;

namespace
{

UvMapper mapper_of(const Mesh& mesh)
{
    return {mesh, std::make_unique<rendering::RasterFinder>(mesh)};
}

CountedUvMap one_map(const Mesh& mesh, const Camera& camera, int height_px)
{
    return mapper_of(mesh).make(camera, std::vector<int>{height_px}, Progress()).front();
}

/// The map by testing every face for every pixel: slow, and written without the mappers but for the rule of cracks.
UvMap plain_uv_map(const Mesh& mesh, const Camera& camera, int height_px)
{
    const Camera scaled{camera.intrinsics.scaled_to(camera.intrinsics.width_at(height_px), height_px), camera.world_from_camera};
    const int width = scaled.intrinsics.width;
    UvMap map{RasterF(width, height_px, 2), RasterF(width, height_px), RasterF(width, height_px), Raster8(width, height_px)};
    const auto normals = vertex_normals(mesh);
    std::vector<testing::RayHit> met;
    RasterF depth(width, height_px);
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            met.push_back(testing::cast(mesh, scaled.world_from_camera.translation, scaled.ray(x + 0.5, y + 0.5)));
            depth.at(x, y) = static_cast<float>(met.back().distance);
        }
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            const testing::RayHit& hit = met[static_cast<std::size_t>(y * width + x)];
            if (!hit.found() || !hit.front || hit.distance < 0.05 || seen_through_crack(depth, x, y))
                continue;
            Vec2d uv;
            Vec3d normal;
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto corner = mesh.texcoords[3 * hit.triangle + k];
                uv = uv + Vec2d{corner.x, corner.y} * hit.weights[k];
                normal += vec_cast<double>(normals[mesh.triangles[hit.triangle][k]]) * hit.weights[k];
            }
            map.uv.at(x, y, 0) = static_cast<float>(uv.x);
            map.uv.at(x, y, 1) = static_cast<float>(uv.y);
            map.depth.at(x, y) = depth.at(x, y);
            const Vec3d ray = normalized(scaled.ray(x + 0.5, y + 0.5));
            map.cosine.at(x, y) = static_cast<float>(std::clamp(-dot(normalized(normal), ray), 0.0, 1.0));
            map.valid.at(x, y) = 1;
        }
    return map;
}

/// Equal to the plain map but for `other` pixels at most, whose rays pass an edge within rounding.
void check_against_plain(const Mesh& mesh, const Camera& camera, int height_px, int other)
{
    const UvMap map = one_map(mesh, camera, height_px).map;
    const UvMap plain = plain_uv_map(mesh, camera, height_px);
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
    const Camera camera{{30, 30, 16, 16, -1.5, -1.5}, {}};
    for (const Mesh& mesh : {testing::rectangle({0, 0, 1}, {0, 2, 0}, {2, 0, 0}, 16, 16),
                             testing::rectangle({2, 0, 1}, {-2, 0, 0}, {0, 2, 0}, 16, 16)})
    {
        std::vector<FaceMap> faces(1, FaceMap(30, 30));
        rendering::RasterFinder(mesh).find(std::span(&camera, 1), Progress{}, faces);
        CHECK(std::ranges::count(faces.front().values, no_face) == 0);
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
            CHECK(counts.valid + counts.back_face + counts.too_near + counts.crack + counts.nothing == 3000);
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
    UvMapper one = mapper_of(mesh);
    UvMapper many = mapper_of(mesh);
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
