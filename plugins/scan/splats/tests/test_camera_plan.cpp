#include "camera_plan.h"
#include "catch.h"
#include "splat_scenes.h"

#include <fresco/geometry/upright.h>
#include <fresco/testing.h>

#include <algorithm>

using namespace scan_splats;
using namespace splat_scenes;

namespace
{

testing::TestRun& quiet()
{
    static testing::TestRun run;
    return run;
}

/// Area-weighted mean of how much the squares within the box face `toward`; 1 if all do.
double facing(const Mesh& squares, const Splats& splats, Vec3d low, Vec3d high, Vec3d toward)
{
    const auto normals = face_normals(squares);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        const Vec3d c = vec_cast<double>(splats.centers[i]);
        if (c.x < low.x || c.y < low.y || c.z < low.z || c.x > high.x || c.y > high.y || c.z > high.z)
            continue;
        sum += dot(vec_cast<double>(normals[2 * i]), toward);
        ++count;
    }
    REQUIRE(count > 20);
    return sum / count;
}

}  // namespace

TEST_CASE("rays end at the surface", "[scan.splats]")
{
    const Splats splats = room();
    const OpacityGrid grid(splats);
    const Vec3d eye{0.5, 2.5, 1.2};
    const auto check = [&](Vec3d direction, Vec3d end)
    {
        const auto voxel = grid.cast(eye, direction, 0);
        REQUIRE(voxel != OpacityGrid::none);
        CHECK(length(grid.center(voxel) - end) < 2 * grid.voxel_m());
    };
    check({1, 0, 0}, {4, 2.5, 1.2});
    check({-1, 0, 0}, {0, 2.5, 1.2});
    check({0, 0, -1}, {0.5, 2.5, 0});
    check({0.6, -0.8, 0}, {0.5 + 0.6 * 3.125, 0, 1.2});
    CHECK(grid.cast({0.5, 2.5, 5}, {0, 0, 1}, 0) == OpacityGrid::none);
    CHECK(grid.cast({0.5, 2.5, 5}, {0, 1, 0}, 0) == OpacityGrid::none);
    const auto from_outside = grid.cast({0.5, 2.5, 5}, {0, 0, -1}, 0);
    REQUIRE(from_outside != OpacityGrid::none);
    CHECK(std::abs(grid.center(from_outside).z - 2.5) < 2 * grid.voxel_m());
    CHECK(grid.voxel_at({100, 0, 0}) == OpacityGrid::none);
    for (const std::size_t voxel : {std::size_t{0}, grid.count() / 2, grid.count() - 1})
        CHECK(grid.voxel_at(grid.center(voxel)) == voxel);
}

TEST_CASE("a room is seen from inside, with or without its ceiling", "[scan.splats]")
{
    const bool with_ceiling = GENERATE(true, false);
    CAPTURE(with_ceiling);
    const Splats splats = room(with_ceiling);
    const OpacityGrid grid(splats);
    const Places places = find_places(grid, Stand::automatic, quiet());
    REQUIRE(places.inside);
    CHECK(places.inside_share > 0.8);
    const CameraPlan plan = plan_cameras(grid, places, {0, 0, 1}, quiet());
    CHECK(plan.seen_share > 0.9);
    REQUIRE(plan.cameras.size() >= 8);
    for (const Camera& camera : plan.cameras)
    {
        const Vec3d eye = camera.world_from_camera.translation;
        CHECK((eye.x > 0 && eye.y > 0 && eye.z > 0 && eye.x < 4 && eye.y < 3 && eye.z < 2.7));
        CHECK_FALSE((eye.x > 3.2 && eye.x < 3.8 && eye.y > 0.3 && eye.y < 1.3 && eye.z < 1.9));  // In the cupboard.
        CHECK(camera.world_from_camera.rotation_error() < 1e-9);
        CHECK(std::abs(camera.world_from_camera.rotation(2, 0)) < 1e-9);  // Level.
        CHECK(camera.world_from_camera.rotation(2, 1) <= 1e-9);
    }
    const Mesh squares = facing_squares(splats, grid, true, quiet());
    CHECK(facing(squares, splats, {-0.1, -0.1, 0.2}, {0.01, 3.1, 2.3}, {1, 0, 0}) > 0.95);
    CHECK(facing(squares, splats, {0.2, 0.2, -0.1}, {1.4, 2.8, 0.01}, {0, 0, 1}) > 0.95);
    CHECK(geometry::find_up(squares, std::nullopt).direction.z > 0.99);
}

TEST_CASE("an object is seen from around, not from below", "[scan.splats]")
{
    const Splats splats = statue();
    const OpacityGrid grid(splats);
    const Places places = find_places(grid, Stand::automatic, quiet());
    REQUIRE_FALSE(places.inside);
    CHECK(places.around_share > 0.8);
    const CameraPlan plan = plan_cameras(grid, places, {0, 0, 1}, quiet());
    CHECK(plan.seen_share > 0.9);
    REQUIRE(plan.cameras.size() >= 8);
    for (const Camera& camera : plan.cameras)
    {
        const Vec3d out = camera.world_from_camera.translation - grid.middle();
        CHECK(length(out) > 1.5 * grid.radius_m());
        CHECK(out.z > -0.1 * length(out) - 1e-9);
        CHECK(camera.project(grid.middle()).z > 0);
    }
    const Mesh squares = facing_squares(splats, grid, false, quiet());
    CHECK(facing(squares, splats, {-0.05, -0.05, 0.38}, {0.05, 0.05, 0.5}, {0, 0, 1}) > 0.85);
}

TEST_CASE("where cameras stand can be said, but not inside of nothing", "[scan.splats]")
{
    CHECK_FALSE(find_places(OpacityGrid(room()), Stand::around, quiet()).inside);
    Splats sheet;
    rectangle(sheet, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.02);
    const OpacityGrid grid(sheet);
    CHECK_FALSE(find_places(grid, Stand::automatic, quiet()).inside);
    CHECK_THROWS_WITH(find_places(grid, Stand::inside, quiet()), Catch::Contains("encloses no free space"));
}

TEST_CASE("plans are the same for any number of threads", "[scan.splats]")
{
    const Splats splats = statue();
    const OpacityGrid grid(splats);
    testing::TestRun one(1), four(4);
    const auto plan = [&](testing::TestRun& run) {
        return plan_cameras(grid, find_places(grid, Stand::automatic, run), {0, 0, 1}, run).cameras;
    };
    CHECK(plan(one) == plan(four));
    CHECK(facing_squares(splats, grid, false, one).positions == facing_squares(splats, grid, false, four).positions);
}

TEST_CASE("splats without extent or substance are refused", "[scan.splats]")
{
    Splats splats;
    add(splats, {1, 2, 3}, {0, 0, 1}, 0.1);
    CHECK_THROWS_WITH(OpacityGrid(splats), Catch::Contains("lie at one point"));
    splats.scales[0] = {1e-6F, 1e-6F, 1e-6F};
    add(splats, {2, 2, 3}, {0, 0, 1}, 1e-6);
    CHECK_THROWS_WITH(OpacityGrid(splats), Catch::Contains("too faint or too few"));
}
