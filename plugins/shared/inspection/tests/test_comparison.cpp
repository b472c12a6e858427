#include "catch.h"
#include "explain_depths.h"

#include <fresco/inspection/agreement.h>
#include <fresco/inspection/views.h>
#include <fresco/inspection/wording.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <algorithm>

using namespace fresco;
using namespace fresco::inspect;

namespace
{

/// A wall of 20 m x 20 m at z = 2 behind one of 1 m x 20 m at z = 1, x from 0 on.
Mesh two_walls()
{
    Mesh mesh = testing::rectangle({-10, -10, 2}, {0, 20, 0}, {20, 0, 0});
    testing::append(mesh, testing::rectangle({0, -10, 1}, {0, 20, 0}, {1, 0, 0}));
    return mesh;
}

}  // namespace

TEST_CASE("quaternions are put into the other order", "[inspection]")
{
    // w x y z = 0.8 0.6 0 0, read as x y z w: w = 0, x = 0.8, y = 0.6, half a turn about (0.8, 0.6, 0).
    RigidTransform meant_pose;
    meant_pose.rotation.m = {1, 0, 0, 0, 0.28, -0.96, 0, 0.96, 0.28};
    meant_pose.translation = {1, 2, 3};
    RigidTransform read;
    read.rotation.m = {0.28, 0.96, 0, 0.96, -0.28, 0, 0, 0, -1};
    read.translation = {1, 2, 3};
    const auto same = [](const RigidTransform& a, const RigidTransform& b)
    {
        for (std::size_t i = 0; i < 9; ++i)
            CHECK(a.rotation.m[i] == Approx(b.rotation.m[i]).margin(1e-12));
        CHECK(length(a.translation - b.translation) < 1e-12);
    };
    same(meant(read, Reading::scalar_first), meant_pose);
    same(meant(read.inverse(), Reading::inverted_scalar_first), meant_pose.inverse());
    same(meant(meant_pose.inverse(), Reading::inverted_scalar_last), read.inverse());
}

TEST_CASE("depths are compared with the mesh's where it is", "[inspection]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    const Camera seen = testing::camera(8, 4, 4);
    DepthView frame{seen.world_from_camera, seen.intrinsics, seen.intrinsics, {}, {}};
    // Left of the middle the far wall, right of it the near one up to x = 1, z = 1, which is the picture's border.
    frame.samples = {{1.5F, 2, 2.0F}, {2.5F, 2, 4.0F}, {5.5F, 2, 1.025F}, {6.5F, 2, 2.0F}, {4.5F, 1, 0.5F}};
    const auto found = depth_ratios(&scene, {frame}, {}, 1);
    REQUIRE(found.size() == 1);
    REQUIRE(found[0].ratios.size() == 5);
    CHECK(found[0].ratios[1] == Approx(0.5));
    CHECK(found[0].ratios[2] == Approx(1 / 1.025));
    const double partly = (0.04 - (1 - 1 / 1.025)) / 0.03;
    const Agreement sum = total(agreement(found, 1));
    CHECK(sum.samples == 5);
    CHECK(sum.agreeing == Approx(1 + partly));
    CHECK(sum.in_front == Approx(2 + (1 - partly)));
    CHECK(sum.behind == Approx(1));
    CHECK(sum.seen_through == 2);
    CHECK(sum.covered_share() == Approx(1));
    CHECK(sum.share() == Approx((1 + partly) / 4.5));
    CHECK(median_error(found, 1) == Approx(0.5));
    CHECK(front_share(found, 1) == 1);
    // Pixels that the mesh does not cover do not count.
    Mesh near = mesh;
    near.triangles.erase(near.triangles.begin(), near.triangles.begin() + 2);
    const raycast::Scene near_only(near);
    const Agreement part = total(agreement(depth_ratios(&near_only, {frame}, {}, 1), 1));
    CHECK(part.covered_share() == Approx(0.6));
    CHECK(part.share() == Approx(partly / 2.5));

    const std::vector<FrameRatios> many{{{0, 0.01F, 0.2F, 0.248F, 0.25F}, {}}, {{0.254F, 1, 1.02F}, {}}};
    CHECK(best_scale(many) == 0.25);

    RasterF depth(80, 8, 1, 1.5F);
    depth.at(1, 1) = 0;
    const auto samples = sample_depth(depth, 40);
    CHECK(samples.size() == 4 * 40 - 1);
    CHECK(samples.front().x == 3.5F);
}

TEST_CASE("without a mesh, points of one view are looked up in the others of its group", "[inspection]")
{
    const auto seen = [](double x, float depth, std::size_t group)
    {
        const Camera at = testing::camera(80, 60, 40, {x, 0, 0});
        return DepthView{
            at.world_from_camera, at.intrinsics, at.intrinsics, {}, sample_depth(RasterF(80, 60, 1, depth), 40), group};
    };
    // A wall 2 m away, by two cameras half a meter apart: ten of 80 columns.
    const auto ratios = [&](float other, const Assumption& assumption = {}) {
        return depth_ratios(nullptr, {seen(0, 2, 0), seen(0.5, other, 0), seen(0, 2, 1)}, assumption, 1);
    };
    const Agreement right = total(agreement(ratios(2), 1));
    CHECK(right.share() == Approx(1));
    CHECK(right.covered_share() == Approx(0.85).margin(0.03));
    CHECK(ratios(2)[2].ratios.empty());
    // Seen through by the other camera, and hidden.
    CHECK(std::ranges::max(ratios(4)[0].ratios) == Approx(0.5));
    CHECK(std::ranges::max(ratios(1.5F)[0].ratios) == Approx(2 / 1.5));
    // Only the quotient of the units counts.
    const auto a = ratios(2.2F, {.pose_scale = 0.1})[0].ratios, b = ratios(2.2F, {.depth_scale = 10})[0].ratios;
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        CHECK(b[i] / 10 == Approx(a[i]).margin(1e-4));
}

TEST_CASE("a mistake is found only if it explains most, clearly better, in enough frames", "[inspection]")
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
    // One frame that gains, four that lose.
    std::vector<Agreement> before = frames(5, 500, 250, 250);
    std::vector<Agreement> after = frames(5, 450, 300, 250);
    before[0] = {9000, 0, 4500, 4500};
    after[0] = {9000, 9000, 0, 0};
    CHECK_FALSE(explains(before, after));
    // As good where it is, and far more of it.
    CHECK(explains(frames(5, 100, 10, 0), frames(5, 900, 50, 0)));
    // Two frames have no interval.
    CHECK(explains(frames(2, 100, 500, 200), frames(2, 800, 50, 50)));
    CHECK_FALSE(explains(frames(2, 350, 300, 300), frames(2, 700, 200, 100)));

    // The floor of a furnished room fits; surface in front of the measured depth does not.
    CHECK(fits({1000, 450, 10, 540}));
    CHECK_FALSE(fits({1000, 450, 200, 350}));

    CHECK(gains({0, 0, 0.1, 0}, {0.5, 0.4, 0.6, 0.5}));
    CHECK_FALSE(gains({0, 0, 0.1, 0}, {0.5, -0.4, 0.6, -0.5}));
}

TEST_CASE("advice names the option that mends it, but no factor for a focal length at the end of the search", "[inspection]")
{
    const auto told = [](const Assumption& assumption, double extent = 6)
    {
        Diagnosis diagnosis;
        diagnosis.assumption = assumption;
        std::vector<Finding> findings;
        tell_assumption(diagnosis, extent, false, findings);
        REQUIRE(findings.size() == 1);
        return findings.front().text;
    };
    CHECK_THAT(told({.focal_scale = 0.8}), Catch::Contains("25 % too large: multiply it by 0.8"));
    CHECK_THAT(told({.focal_scale = 2.2}), Catch::Contains("55 % too small or more"));
    CHECK_THAT(told({.pose_scale = 5.8}), Catch::Contains("multiply them by 5.8"));
    CHECK_THAT(told({.pose_scale = 5.8, .depth_scale = 5.8}), Catch::Contains("multiply unit_m of scan.mesh by 0.172"));
    CHECK_THAT(told({.depth_scale = 1.9}), Catch::Contains("depth_unit_m by 1.9") && Catch::Contains("unit_m of both by 0.526"));
    CHECK_THAT(told({.depth_scale = 0.2}, 0), Catch::Contains("multiply depth_unit_m by 0.2 (0.0002 if it is 0.001) or") &&
                                                  Catch::Contains("the positions by 5 (unit_m of scan.recording)"));
    CHECK_THAT(told({.pose_scale = 0.4}, 0), Catch::Contains("multiply the positions by 0.4 (unit_m of scan.recording) or") &&
                                                 Catch::Contains("depth_unit_m by 2.5 (0.0025 if it is 0.001)"));
    CHECK_THAT(told({.world_turn = {{1, 0, 0, 0, -1, 0, 0, 0, 1}}}), Catch::Contains("x -y z and swap two corners"));
}

TEST_CASE("corrections that are only right together say so", "[inspection]")
{
    Diagnosis diagnosis;
    diagnosis.depths = 100;
    diagnosis.recorded.agreement = 0.06;
    diagnosis.explained.agreement = 0.83;
    const auto told = [&]
    {
        std::vector<Finding> findings;
        tell_assumption(diagnosis, 0, false, findings);
        tell_figures(diagnosis, findings);
        return findings;
    };
    diagnosis.assumption.reading = Reading::inverted;
    REQUIRE(told().size() == 1);
    CHECK_THAT(told()[0].text, Catch::Contains("axes: opengl), also negate the second and third columns") &&
                                   Catch::Contains("(83 % of the covered depths agree then, 6 % as recorded)"));
    diagnosis.assumption.camera_turn = axis_rotations()[1];
    REQUIRE(told().size() == 2);
    CHECK_THAT(told()[0].text, !Catch::Contains("also negate") && Catch::Contains("(1 of 2 corrections that belong together)"));
    CHECK_THAT(told()[1].text, Catch::Contains("afterward, but not in files with OpenGL's axes") &&
                                   Catch::Contains("(with all 2 corrections together, 83 %"));
}
