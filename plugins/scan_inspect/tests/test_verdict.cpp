#include "agreement.h"
#include "catch.h"
#include "move.h"
#include "outline.h"
#include "verdict.h"
#include "wording.h"

using namespace fresco;
using namespace fresco::inspect;

TEST_CASE("a mistake is found only if it explains most, clearly better, in enough frames", "[scan.inspect]")
{
    const auto frames = [](std::size_t count, double agreeing, double in_front, double behind) {
        return std::vector<Agreement>(count, {1000, agreeing, in_front, behind});
    };
    const auto chance = frames(5, 50, 300, 300);
    CHECK(explains(chance, frames(5, 700, 50, 50)));
    // A quarter of what is covered, as a wrong turn of the axes reaches.
    CHECK_FALSE(explains(chance, frames(5, 200, 500, 100)));
    CHECK(improves(chance, frames(5, 300, 400, 100)));
    // Better, but the recording is fine.
    CHECK_FALSE(explains(frames(5, 800, 100, 0), frames(5, 850, 60, 0)));
    // A few depths that agree.
    CHECK_FALSE(explains(chance, frames(5, 15, 0, 0)));
    CHECK_FALSE(explains(frames(5, 200, 100, 0), frames(5, 100, 0, 0)));
    // One frame that gains, four that lose.
    std::vector<Agreement> before = frames(5, 500, 250, 250);
    std::vector<Agreement> after = frames(5, 450, 300, 250);
    before[0] = {9000, 0, 4500, 4500};
    after[0] = {9000, 9000, 0, 0};
    CHECK_FALSE(explains(before, after));
    // As good where it is, and far more of it.
    CHECK(explains(frames(5, 100, 10, 0), frames(5, 900, 50, 0)));
    CHECK_FALSE(explains(frames(5, 400, 40, 0), frames(5, 900, 50, 0)));
    // Two frames have no interval.
    CHECK(explains(frames(2, 100, 500, 200), frames(2, 800, 50, 50)));
    CHECK_FALSE(explains(frames(2, 350, 300, 300), frames(2, 700, 200, 100)));

    // The floor of a furnished room fits; surface in front of the measured depth does not.
    CHECK(fits({1000, 450, 10, 540}));
    CHECK_FALSE(fits({1000, 450, 200, 350}));
    CHECK_FALSE(fits({1000, 200, 10, 790}));
    CHECK_FALSE(fits({}));

    CHECK(gains({0, 0, 0.1, 0}, {0.5, 0.4, 0.6, 0.5}));
    CHECK_FALSE(gains({0, 0, 0.1, 0}, {0.5, -0.4, 0.6, -0.5}));
}

TEST_CASE("a moved mesh is moved back", "[scan.inspect]")
{
    // Floor and two walls of 4 m.
    Mesh corner;
    corner.positions = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 4}, {4, 0, 4}, {0, 4, 4}};
    corner.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 5, 1}, {0, 4, 5}, {0, 3, 6}, {0, 6, 4}};
    std::vector<DepthView> views;
    {
        const raycast::Scene scene(corner);
        for (const double side : {1.2, 2.0, 2.8})
        {
            // Toward the corner along (-1, -1, -1).
            Camera seen{{40, 40, 20, 20, 20, 20}, {}};
            const Vec3d forward = normalized(Vec3d{-1, -1, -1});
            const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1}));
            const Vec3d down = cross(forward, right);
            seen.world_from_camera.rotation.m = {right.x,   down.x,  forward.x, right.y,  down.y,
                                                 forward.y, right.z, down.z,    forward.z};
            seen.world_from_camera.translation = {side, 4 - side, 2};
            views.push_back({{{seen.world_from_camera}, 0},
                             seen.intrinsics,
                             seen.intrinsics,
                             {},
                             sample_depth(mesh_depth(scene, seen, Progress{}), 40)});
        }
    }
    for (Vec3f& p : corner.positions)
        p += Vec3f{0.1F, -0.05F, 0.08F};
    const RigidTransform move = best_move(raycast::Scene(corner), views, {}, 1);
    CHECK(length(move.translation - Vec3d{0.1, -0.05, 0.08}) < 1e-3);
    CHECK(move.rotation(0, 0) == Approx(1).margin(1e-5));
}

TEST_CASE("a focal length at the end of the search is no advice", "[scan.inspect]")
{
    const auto told = [](double depth, double color)
    {
        Diagnosis diagnosis;
        diagnosis.assumption.focal_scale = depth;
        diagnosis.color_change.focal_scale = color;
        std::vector<Finding> findings;
        tell_assumption(diagnosis, 5, false, findings);
        tell_color(diagnosis, false, findings);
        REQUIRE(findings.size() == 1);
        return findings.front().text;
    };
    CHECK_THAT(told(1, 0.8), Catch::Contains("25 % too large: multiply it by 0.8"));
    CHECK_THAT(told(1, 0.72), Catch::Contains("39 % too large or more: was it calibrated for another picture size?"));
    CHECK_THAT(told(1.45, 1), Catch::Contains("31 % too small or more"));
    CHECK_THAT(told(1.25, 1), Catch::Contains("20 % too small: multiply it by 1.25"));
    CHECK_THAT(told(0.68, 0.68), Catch::Contains("both cameras") && Catch::Contains("or more"));
}

TEST_CASE("advice names the option that mends it", "[scan.inspect]")
{
    const auto told = [](const Assumption& assumption, double extent)
    {
        Diagnosis diagnosis;
        diagnosis.assumption = assumption;
        std::vector<Finding> findings;
        tell_assumption(diagnosis, extent, false, findings);
        REQUIRE(findings.size() == 1);
        CHECK(findings.front().certain);
        return findings.front().text;
    };
    Assumption a;
    a.pose_scale = 5.8;
    CHECK_THAT(told(a, 6), Catch::Contains("multiply them by 5.8") && Catch::Contains("unit_m of scan.colmap"));
    a.depth_scale = 5.8;
    CHECK_THAT(told(a, 6), Catch::Contains("multiply unit_m of scan.mesh by 0.172"));
    a = {};
    a.depth_scale = 1.9;
    CHECK_THAT(told(a, 6), Catch::Contains("depth_unit_m by 1.9") && Catch::Contains("unit_m of both by 0.526"));
    a = {};
    a.lag_frames = -2.4;
    CHECK_THAT(told(a, 6), Catch::Contains("the pose listed 2.4 frames earlier"));
    a = {};
    a.world_turn(1, 1) = -1;
    CHECK_THAT(told(a, 6), Catch::Contains("replace each vertex's x y z by its x -y z and swap two corners"));
    a = {};
    a.move.translation = {0.1, 0, 0};
    CHECK_THAT(told(a, 6), Catch::Contains("transform: [1.000000, 0.000000, 0.000000, -0.1000, "));
}
