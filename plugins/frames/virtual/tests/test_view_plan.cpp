#include "catch.h"
#include "free_space.h"
#include "rooms.h"
#include "view_plan.h"

#include <fresco/npy.h>
#include <fresco/testing.h>

#include <numeric>

using namespace fresco;
using namespace fresco::virtual_views;
using namespace rooms;

namespace
{

std::vector<std::uint32_t> first_numbers(std::size_t count)
{
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0U);
    return numbers;
}

Vec3d middle_of(const SurfacePoint& point)
{
    return vec_cast<double>(point.position);
}

PlanRules rules(const Intrinsics& intrinsics, double distance_m)
{
    return {
        .intrinsics = intrinsics, .upright = {{0, 0, 1}, 0}, .distance_m = distance_m, .most_unpainted = 0, .most_views = 1000};
}

struct World
{
    Mesh mesh = room_with_cupboard();
    raycast::Scene scene{mesh};
    int cells_px = 128;
    std::vector<SurfacePoint> points = surface_points(mesh, cells_px, testing::TestRun(1));
    Frames frames{};
    std::vector<Vec3d> eyes{frame_before_cupboard().color.world_from_camera.translation};
    std::vector<Vec3d> places =
        free_space(scene, VoxelGrid(mesh, eyes, {.voxel_m = 0.4, .clearance_m = 0.2}), eyes, 0.2, testing::TestRun(1));

    World() { frames.frames.push_back(frame_before_cupboard()); }
};

struct WithWorld
{
    World world;
};

}  // namespace

TEST_CASE_METHOD(WithWorld, "a camera paints what lies in its picture and is not masked, and the gap around it",
                 "[frames.virtual]")
{
    const testing::TemporaryFolder folder;
    Frame& frame = world.frames.frames.front();
    Raster8 mask(64, 48, 1, 255);
    std::fill_n(mask.values.begin(), 64 * 24, std::uint8_t{0});
    write_npy(folder.path() / "mask.npy", mask);
    const auto painted_by_frame = [&](int gap, int threads)
    {
        Coverage coverage(world.scene, world.points, world.cells_px, gap);
        testing::TestRun run(threads);
        // The cupboard is 1.7 m away, the far corners 3.7 m.
        const double distance_m = add_frames(coverage, world.frames, run);
        CHECK(distance_m > 1.7);
        CHECK(distance_m < 3.7);
        std::vector<std::uint8_t> painted(world.points.size());
        for (std::uint32_t i = 0; i < painted.size(); ++i)
            painted[i] = coverage.painted(i) ? 1 : 0;
        CHECK(static_cast<std::size_t>(std::ranges::count(painted, 0)) == coverage.unpainted().size());
        return painted;
    };
    for (const bool masked : {false, true})
    {
        if (masked)
            frame.mask = {folder.path() / "mask.npy", ""};
        const auto none = painted_by_frame(0, 1);
        std::vector<std::uint8_t> slow(world.points.size());
        for (std::uint32_t i = 0; i < slow.size(); ++i)
        {
            const Vec3d at = frame.color.project(middle_of(world.points[i]));
            if (at.z > 0 && at.x >= 0 && at.x < 64 && at.y >= (masked ? 24 : 0) && at.y < 48 &&
                slow_sees(world.mesh, world.eyes[0], middle_of(world.points[i]), world.points[i].face))
                slow[i] = 1;
        }
        CHECK(none == slow);
        const auto wide = painted_by_frame(2, 2);
        for (std::uint32_t i = 0; i < slow.size(); ++i)
        {
            bool near = false;
            for (std::uint32_t j = 0; j < slow.size() && !near; ++j)
            {
                const int across = static_cast<int>(world.points[i].cell % 128) - static_cast<int>(world.points[j].cell % 128);
                const int down = static_cast<int>(world.points[i].cell / 128) - static_cast<int>(world.points[j].cell / 128);
                near = slow[j] != 0 && std::max(std::abs(across), std::abs(down)) <= 2 &&
                       world.points[i].chart == world.points[j].chart;
            }
            CHECK((wide[i] != 0) == near);
        }
    }
}

TEST_CASE_METHOD(WithWorld, "a witness is found for exactly the points that some place sees", "[frames.virtual]")
{
    const auto all = first_numbers(world.points.size());
    const auto found = witnesses(world.scene, world.points, world.places, all, testing::TestRun(2));
    std::size_t unseen = 0;
    for (const std::uint32_t i : all)
    {
        const SurfacePoint& point = world.points[i];
        const auto sees = [&](Vec3d place) { return slow_sees(world.mesh, place, middle_of(point), point.face); };
        if (found[i] != nobody)
            CHECK(sees(world.places[found[i]]));
        else
            CHECK(std::ranges::none_of(world.places, sees));
        unseen += found[i] == nobody ? 1 : 0;
    }
    // The cupboard's floor, the room's below it, and the wall behind the wall, nothing else.
    CHECK(static_cast<double>(unseen) == Approx(40.96 * (0.6 + 0.6 + 7.5)).epsilon(0.1));
}

TEST_CASE_METHOD(WithWorld, "planned cameras paint all that is wanted", "[frames.virtual]")
{
    const auto planned = [&](int gap, int threads)
    {
        Coverage coverage(world.scene, world.points, world.cells_px, gap);
        testing::TestRun run(threads);
        const double distance_m = add_frames(coverage, world.frames, run);
        auto wanted = coverage.unpainted();
        const auto witness_of = witnesses(world.scene, world.points, world.places, wanted, run);
        std::erase_if(wanted, [&](std::uint32_t point) { return witness_of[point] == nobody; });
        const auto plan = plan_views(coverage, world.places, wanted, witness_of,
                                     rules(world.frames.frames[0].color.intrinsics, distance_m), run);
        CHECK(std::ranges::all_of(wanted, [&](std::uint32_t point) { return coverage.painted(point); }));
        CHECK(plan.unpainted.empty());
        return plan.cameras;
    };
    const auto whole = planned(0, 1);
    CHECK(planned(0, 3) == whole);
    // The room takes at least as many as it has sides.
    CHECK(whole.size() >= 6);
    CHECK(whole.size() < 60);
    for (const Camera& camera : whole)
        CHECK(std::ranges::count(world.places, camera.world_from_camera.translation) == 1);
    CHECK(planned(1, 2).size() <= whole.size());
}

TEST_CASE_METHOD(WithWorld, "a telephoto lens is aimed at what lies between the directions", "[frames.virtual]")
{
    Coverage coverage(world.scene, world.points, world.cells_px, 0);
    testing::TestRun run(2);
    std::vector<std::uint32_t> wanted;
    for (const std::uint32_t point :
         visible_points(world.scene, world.points, world.places[0], first_numbers(world.points.size())))
        if (point % 100 == 0)
            wanted.push_back(point);
    CHECK(wanted.size() > 5);
    const std::span<const Vec3d> one_place(world.places.data(), 1);
    const auto plan = plan_views(coverage, one_place, wanted, std::vector<std::uint32_t>(world.points.size()),
                                 rules({64, 48, 3000, 3000, 32, 24}, 1), run);
    CHECK(plan.unpainted.empty());
    CHECK(plan.cameras.size() <= wanted.size());
}

TEST_CASE("cameras stand upright as the recorded ones do", "[frames.virtual]")
{
    const Intrinsics intrinsics{64, 48, 50, 50, 32, 24};
    const auto check = [&](int turns, Vec3d up_in_camera)
    {
        for (const Vec3d forward : {Vec3d{1, 0, 0}, Vec3d{0.6, 0, -0.8}, Vec3d{0, 0, 1}})
        {
            const Camera camera = level_camera(intrinsics, {1, 2, 3}, forward, {{0, 0, 1}, turns});
            CHECK(camera.world_from_camera.rotation_error() < 1e-9);
            CHECK(length(camera.world_from_camera.direction({0, 0, 1}) - forward) < 1e-9);
            CHECK(camera.world_from_camera.translation == Vec3d{1, 2, 3});
            if (forward.z < 1)
                CHECK(dot(camera.world_from_camera.direction(up_in_camera), {0, 0, 1}) ==
                      Approx(std::hypot(forward.x, forward.y)));
            Frames frames;
            frames.frames.emplace_back().color = camera;
            if (forward.z < 1)
                CHECK(upright_of(frames, {0, 0, 1}).quarter_turns == turns);
        }
    };
    check(0, {0, -1, 0});
    check(1, {-1, 0, 0});
    check(2, {0, 1, 0});
    check(3, {1, 0, 0});
}
