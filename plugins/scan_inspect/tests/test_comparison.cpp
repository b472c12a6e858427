#include "agreement.h"
#include "catch.h"
#include "drawing.h"
#include "explain_depths.h"
#include "views.h"
#include "wording.h"

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

Camera camera(int width, int height)
{
    return testing::camera(width, height, 0.5 * width);
}

}  // namespace

TEST_CASE("poses are corrected as their assumption has it", "[scan.inspect]")
{
    // True: at (1, 2, 3), looking along the world's x; the columns are right, down, forward.
    RigidTransform world_from_camera;
    world_from_camera.rotation.m = {0, 0, 1, -1, 0, 0, 0, -1, 0};
    world_from_camera.translation = {1, 2, 3};
    RigidTransform recorded = world_from_camera;
    for (const int row : {0, 1, 2})
        for (const int column : {1, 2})
            recorded.rotation(row, column) = -recorded.rotation(row, column);
    recorded.translation = {1000, 2000, 3000};
    const auto alone = [](const RigidTransform& pose) { return PoseTrack{{pose}, 0}; };
    const Mat3 opengl = axis_rotations()[1];
    CHECK(axis_names(opengl) == "+x -y -z");
    Assumption a;
    CHECK(a.pose(alone(recorded)) == recorded);
    a.pose_scale = 0.001;
    a.camera_turn = opengl;
    CHECK(a.pose(alone(recorded)) == world_from_camera);
    a = {};
    a.reading = Reading::inverted;
    CHECK(length(a.pose(alone(world_from_camera)).point({1, 2, 3})) == 0);
    // The world's y is the mesh's z; then the mesh is moved up.
    a = {};
    a.world_turn.m = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    a.move.translation = {0, 0, 0.5};
    CHECK(axis_names(a.world_turn) == "+x +z -y");
    CHECK(a.pose(alone(world_from_camera)).translation == Vec3d{1, -3, 2.5});

    const auto& all = axis_rotations();
    REQUIRE(all.size() == 24);
    CHECK(all.front() == Mat3{});
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        CHECK(determinant(all[i]) == 1);
        CHECK(std::count(all.begin(), all.end(), all[i]) == 1);
    }
    CHECK(usual_scale(0.26) == 0.25);
    CHECK(usual_scale(0.6) == 0.6);
}

TEST_CASE("quaternions are put into the other order", "[scan.inspect]")
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
    same(meant(meant_pose, Reading::scalar_last), read);
    same(meant(read.inverse(), Reading::inverted_scalar_first), meant_pose.inverse());
    same(meant(meant_pose.inverse(), Reading::inverted_scalar_last), read.inverse());
    CHECK(meant(meant_pose, Reading::transposed).rotation == transposed(meant_pose.rotation));
}

TEST_CASE("a lag lies between recorded poses, or at the first or last", "[scan.inspect]")
{
    PoseTrack track;
    for (const double angle : {0.0, 0.2, 0.6})
    {
        RigidTransform& pose = track.poses.emplace_back();
        pose.rotation.m = {std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1};
        pose.translation = {10 * angle, 0, 1};
    }
    track.own = 1;
    const auto at = [&](double lag)
    {
        Assumption a;
        a.lag_frames = lag;
        const RigidTransform pose = a.pose(track);
        return std::pair(std::atan2(pose.rotation(1, 0), pose.rotation(0, 0)), pose.translation.x);
    };
    CHECK(at(0.5).first == Approx(0.4));
    CHECK(at(0.5).second == Approx(4));
    CHECK(at(-0.5).first == Approx(0.1));
    CHECK(at(1).second == Approx(6));
    CHECK(at(3).second == Approx(6));
    CHECK(at(-3).first == Approx(0).margin(1e-12));
}

TEST_CASE("depths are compared with the mesh's where it is", "[scan.inspect]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    const Camera seen = camera(8, 4);
    DepthView frame{{{seen.world_from_camera}, 0}, seen.intrinsics, seen.intrinsics, {}, {}};
    // Left of the middle the far wall, right of it the near one up to x = 1, z = 1, which is the picture's border.
    frame.samples = {{1.5F, 2, 2.0F}, {2.5F, 2, 4.0F}, {5.5F, 2, 1.025F}, {6.5F, 2, 2.0F}, {4.5F, 1, 0.5F}};
    const auto found = depth_ratios(scene, {frame}, {}, 1);
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
    CHECK(sum.covered_share() == Approx(1));
    CHECK(sum.share() == Approx((1 + partly) / 4.5));
    CHECK(median_error(found, 1) == Approx(0.5));
    CHECK(front_share(found, 1) == 1);
    CHECK(depth_ratios(scene, {frame}, {}, 2)[0].ratios.size() == 3);
    // From behind, everything is a back.
    Mesh turned = mesh;
    for (Triangle& t : turned.triangles)
        std::swap(t[0], t[1]);
    CHECK(front_share(depth_ratios(raycast::Scene(turned), {frame}, {}, 1), 1) == 0);
    // What the mesh does not cover does not count.
    Mesh near = mesh;
    near.triangles.erase(near.triangles.begin(), near.triangles.begin() + 2);
    const Agreement part = total(agreement(depth_ratios(raycast::Scene(near), {frame}, {}, 1), 1));
    CHECK(part.covered_share() == Approx(0.6));
    CHECK(part.share() == Approx(partly / 2.5));

    CHECK(agreement_at(1.01) == Approx(1));
    CHECK(agreement_at(0.975) == Approx(0.5));
    CHECK(agreement_at(0) == 0);
    const std::vector<FrameRatios> many{{{0, 0.01F, 0.2F, 0.248F, 0.25F}, {}}, {{0.254F, 1, 1.02F}, {}}};
    CHECK(best_scale(many) == 0.25);
    CHECK(best_scale({}) == 1);
    CHECK(total({}).share() == 0);

    RasterF depth(80, 8, 1, 1.5F);
    depth.at(1, 1) = 0;
    const auto samples = sample_depth(depth, 40);
    CHECK(samples.size() == 4 * 40 - 1);
    CHECK(samples.front().x == 3.5F);
}

TEST_CASE("depth pictures are read as their assumption has it", "[scan.inspect]")
{
    const DepthView view{{{RigidTransform{}}, 0}, {8, 4, 4, 4, 4, 2}, {16, 8, 16, 16, 8, 4}, {{}, {0.5, 0, 0}}, {}};
    const DepthSample sample{7, 2, 2};
    CHECK(measured_ray(view, sample, {}).direction == Vec3d{0.75, 0, 1});
    Assumption a;
    a.along_ray = true;
    CHECK(measured_ray(view, sample, a).depth == Approx(2 / 1.25));
    a = {};
    a.upside_down = true;
    CHECK(measured_ray(view, sample, a).direction == Vec3d{-0.75, 0, 1});
    a = {};
    a.size_scale = 0.5;
    CHECK(measured_ray(view, sample, a).direction == Vec3d{2.5, 0.5, 1});
    a = {};
    a.by_color_camera = true;
    CHECK(measured_ray(view, sample, a).direction == Vec3d{0.375, 0, 1});
    CHECK(depth_pose(view, a).translation.x == 0.5);
    CHECK_FALSE(one_camera(view));
}

TEST_CASE("the outline is the near side of depth steps", "[scan.inspect]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    const RasterF depth = mesh_depth(scene, camera(16, 8), Progress{});
    CHECK(depth.at(7, 4) == Approx(2));
    CHECK(depth.at(8, 4) == Approx(1));
    const Raster8 lines = outline(depth, false);
    for (int x = 0; x < 16; ++x)
        CHECK(int{lines.at(x, 4)} == (x == 8 ? 1 : 0));

    const auto points = silhouette(depth);
    REQUIRE(points.size() == 8);
    CHECK(points.front().x == 8.5F);
    CHECK(points.front().depth == Approx(1));

    // Beside a shadow of two pixels; nothing beside the mesh's own border, or beyond the picture.
    RasterF row(8, 1, 1, 0.0F);
    row.at(1, 0) = 1;
    row.at(4, 0) = 2;
    row.at(5, 0) = 2.05F;
    const Raster8 found = outline(row, false);
    for (int x = 0; x < 8; ++x)
        CHECK(int{found.at(x, 0)} == (x == 1 ? 1 : 0));
    row = RasterF(8, 1, 1, 0.0F);
    row.at(2, 0) = 1;
    CHECK(outline(row, false).at(2, 0) == 0);
    CHECK(outline(row, true).at(2, 0) == 1);
}

TEST_CASE("a picture's edge along the outline is found, also where the camera is off", "[scan.inspect]")
{
    const auto edges_of = [](int edge)
    {
        Raster8 picture(160, 120, 3, 60);
        for (int y = 0; y < 120; ++y)
            for (int x = edge; x < 160; ++x)
                for (int c = 0; c < 3; ++c)
                    picture.at(x, y, c) = 200;
        return edge_strength(picture);
    };
    const auto view_of = [](const RasterF& edges, double shift)
    {
        EdgeView view{camera(160, 120).intrinsics, &edges, {}};
        view.camera.cx += shift;
        std::vector<Vec3d> line{{0, 0, -1}};
        for (int y = 10; y < 110; ++y)
            line.push_back({0, (y - 60) / 40.0, 2});
        add_outline(view, line);
        return view;
    };
    const RasterF middle = edges_of(80);
    const RasterF beside = edges_of(110);
    const EdgeView right = view_of(middle, 0);
    CHECK(right.outline.size() == 100);
    // Stronger than anything around: 4 times, less 1.
    CHECK(edge_response({right}, {}) == Approx(3));
    CHECK(edge_response({view_of(beside, 0)}, {}) == Approx(-1));
    // A frame without an outline says nothing.
    CHECK(edge_response({right, EdgeView{right.camera, &beside, {}}}, {}) == Approx(3));
    CHECK(edge_responses({right, EdgeView{right.camera, &beside, {}}}, {}).back() == 0);
    CHECK(best_change({right}, {}, Progress{}) == CameraChange{});
    // The camera was given a principal point 4.8 px too far right.
    const CameraChange change = best_change({view_of(middle, 4.8)}, {}, testing::TestRun(3));
    CHECK(change.shift_x == Approx(-0.03).margin(0.01));

    CameraChange turned;
    turned.upside_down = true;
    turned.size_scale = 0.5;
    CHECK(changed(right.camera, turned) == Intrinsics{160, 120, 40, 40, 40, 30});

    const RasterF even = edge_strength(Raster8(16, 8, 3, 100));
    CHECK(std::ranges::all_of(even.values, [](float value) { return value == 1; }));
}

TEST_CASE("the picture shows outline, depths and their difference", "[scan.inspect]")
{
    Panel panel;
    panel.picture = Raster8(20, 10, 3, 128);
    panel.outlined = Raster8(20, 10);
    panel.outlined.at(3, 2) = 1;
    panel.measured = RasterF(16, 8, 1, 2.0F);
    panel.measured.at(5, 5) = 0;
    panel.mesh = RasterF(16, 8, 1, 2.0F);
    panel.mesh.at(0, 0) = 1;
    panel.mesh.at(1, 0) = 3;
    Panel suggested = panel;
    suggested.suggested = true;
    const Raster8 sheet = draw({panel, suggested});
    CHECK(sheet.width == 4 + 24 + 3 * 20);
    CHECK(sheet.height == 4 + 2 * 14);
    const auto color = [&](int x, int y) { return Rgb8{sheet.at(x, y, 0), sheet.at(x, y, 1), sheet.at(x, y, 2)}; };
    CHECK(color(4 + 3, 4 + 2) == Rgb8{255, 40, 40});
    CHECK(color(4 + 3, 18 + 2) == Rgb8{40, 255, 80});
    CHECK(color(4, 4) == Rgb8{128, 128, 128});
    const int difference = 4 + 24 + 2 * 20;
    CHECK(color(difference, 4) == Rgb8{255, 0, 0});
    CHECK(color(difference + 1, 4) == Rgb8{0, 0, 255});
    CHECK(color(difference + 2, 4) == Rgb8{255, 255, 255});
    CHECK(color(difference + 5, 4 + 5) == Rgb8{90, 90, 100});
    CHECK(color(28, 4) == Rgb8{255, 255, 255});
}

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
