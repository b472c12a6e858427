#include "convention.h"
#include "depth_agreement.h"
#include "drawing.h"
#include "outline.h"
#include "wording.h"

#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <algorithm>

using namespace fresco;
using namespace fresco::inspect;

namespace
{

/// A wall of 20 m x 20 m at z = 2 behind one of 1 m x 20 m at z = 1, x from 0 on.
Mesh two_walls()
{
    Mesh mesh;
    const auto wall = [&](float left, float right, float z)
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const float y : {-10.0F, 10.0F})
            for (const float x : {left, right})
                mesh.positions.push_back({x, y, z});
        mesh.triangles.push_back({first, first + 2, first + 1});
        mesh.triangles.push_back({first + 1, first + 2, first + 3});
    };
    wall(-10, 10, 2);
    wall(0, 1, 1);
    return mesh;
}

Camera camera(int width, int height)
{
    return {{width, height, 0.5 * width, 0.5 * width, 0.5 * width, 0.5 * height}, {}};
}

}  // namespace

TEST_CASE("poses are corrected as their convention has it", "[scan.inspect]")
{
    // True: at (1, 2, 3), looking along the world's x, its y to the right, its -z ... as columns right, down, forward.
    RigidTransform world_from_camera;
    world_from_camera.rotation.m = {0, 0, 1, -1, 0, 0, 0, -1, 0};
    world_from_camera.translation = {1, 2, 3};
    RigidTransform recorded = world_from_camera;
    for (const int row : {0, 1, 2})
        for (const int column : {1, 2})
            recorded.rotation(row, column) = -recorded.rotation(row, column);
    recorded.translation = {1000, 2000, 3000};
    const Mat3 opengl = axis_rotations()[1];
    CHECK(axis_names(opengl) == "+x -y -z");
    CHECK(Convention{false, 0.001, opengl, {}}.correct(recorded) == world_from_camera);
    CHECK(Convention{}.correct(recorded) == recorded);
    const RigidTransform inverse = Convention{true, 1, {}, {}}.correct(world_from_camera);
    CHECK(length(inverse.point({1, 2, 3})) == 0);
    // The world's y is the mesh's z.
    Mat3 turn;
    turn.m = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    CHECK(axis_names(turn) == "+x +z -y");
    CHECK(Convention{false, 1, {}, turn}.correct(world_from_camera).translation == Vec3d{1, -3, 2});

    const auto& all = axis_rotations();
    REQUIRE(all.size() == 24);
    CHECK(all.front() == Mat3{});
    for (std::size_t i = 0; i < all.size(); ++i)
    {
        CHECK(determinant(all[i]) == 1);
        CHECK(std::count(all.begin(), all.end(), all[i]) == 1);
    }
    const auto candidates = candidate_conventions(true);
    CHECK(candidates.front() == Convention{false, 1, opengl, {}});
    CHECK(candidates.size() == 19 + 92 + 220);
    CHECK(std::count(candidates.begin(), candidates.end(), Convention{}) == 0);
    CHECK(usual_scale(0.26) == 0.25);
    CHECK(usual_scale(0.6) == 0.6);
}

TEST_CASE("depths are compared with the mesh's", "[scan.inspect]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    SampledDepth frame{camera(8, 4), {}};
    // Left of the middle the far wall, right of it the near one up to x = 1, z = 1, which is the picture's border.
    frame.samples = {{1.5F, 2, 2.0F}, {2.5F, 2, 4.0F}, {5.5F, 2, 1.01F}, {6.5F, 2, 2.0F}, {4.5F, 1, 0.5F}};
    const DepthRatios found = depth_ratios(scene, {frame}, {}, 1, 1, Progress{});
    CHECK(found.seen == 5);
    CHECK(found.fronts == 5);
    REQUIRE(found.ratios.size() == 5);
    CHECK(found.ratios[0] == Approx(0.5));
    CHECK(found.ratios[2] == Approx(1 / 1.01));
    CHECK(found.share(1, 0.03) == Approx(0.4));
    CHECK(found.share(1, 0.001) == Approx(0.2));
    CHECK(found.share(0.5, 0.001) == Approx(0.4));
    CHECK(found.loss(1) == Approx((0.3 + (1 - 1 / 1.01)) / 5));
    CHECK(found.median_error(1) == Approx(0.5));
    CHECK(depth_ratios(scene, {frame}, {}, 1, 2, Progress{}).ratios.size() == 3);
    // From behind, everything is a back.
    Mesh turned = mesh;
    for (Triangle& t : turned.triangles)
        std::swap(t[0], t[1]);
    const raycast::Scene other(turned);
    CHECK(depth_ratios(other, {frame}, {}, 1, 1, Progress{}).fronts == 0);
    // Twice the focal length: (2.5 - 4) / 8 still meets the far wall.
    CHECK(depth_ratios(scene, {frame}, {}, 2, 1, Progress{}).seen == 5);
    const std::vector<SampledDepth> many(7, frame);
    CHECK(depth_ratios(scene, many, {}, 1.1, 1, testing::TestRun(1)).ratios ==
          depth_ratios(scene, many, {}, 1.1, 1, testing::TestRun(3)).ratios);

    DepthRatios ratios{{0, 0.01, 0.2, 0.248, 0.25, 0.254, 1, 1.02}, 7, 7};
    CHECK(ratios.best_scale() == 0.25);
    CHECK(DepthRatios{}.best_scale() == 1);
    CHECK(DepthRatios{}.share(1, 0.1) == 0);

    RasterF depth(80, 8, 1, 1.5F);
    depth.at(1, 1) = 0;
    const auto samples = sample_depth(depth, 40);
    CHECK(samples.size() == 4 * 40 - 1);
    CHECK(samples.front().x == 3.5F);
}

TEST_CASE("the outline is the near side of depth steps", "[scan.inspect]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    const RasterF depth = mesh_depth(scene, camera(16, 8), Progress{});
    CHECK(depth.at(7, 4) == Approx(2));
    CHECK(depth.at(8, 4) == Approx(1));
    const Raster8 lines = outline(depth);
    for (int x = 0; x < 16; ++x)
        CHECK(int{lines.at(x, 4)} == (x == 8 ? 1 : 0));

    OutlinedFrame frame{camera(16, 8), {}, {}};
    find_outline(scene, {}, frame, Progress{});
    REQUIRE(frame.outline.size() == 6);
    CHECK(frame.outline.front().x == Approx(1.0 / 16));
    CHECK(frame.outline.front().z == Approx(1));
}

TEST_CASE("a picture's edge along the outline is found, also where the camera is off", "[scan.inspect]")
{
    const Mesh mesh = two_walls();
    const raycast::Scene scene(mesh);
    const auto frame_of = [&](int edge, double shift)
    {
        Raster8 picture(160, 120, 3, 60);
        for (int y = 0; y < 120; ++y)
            for (int x = edge; x < 160; ++x)
                for (int c = 0; c < 3; ++c)
                    picture.at(x, y, c) = 200;
        OutlinedFrame frame{camera(160, 120), edge_strength(picture), {}};
        frame.camera.intrinsics.cx += shift;
        find_outline(scene, {}, frame, Progress{});
        return frame;
    };
    const auto right = frame_of(80, 0);
    // The step is 4 of 160 columns wide (gradient over two, widened by one to each side): 40 times the mean, less 1.
    CHECK(edge_response({right}, {}, {}) == Approx(39).epsilon(0.05));
    CHECK(edge_response({frame_of(110, 0)}, {}, {}) == Approx(-1));
    const CameraChange none = best_change({right}, {}, Progress{});
    CHECK(none.shift_x == 0);
    CHECK(none.focal_scale == 1);
    // The camera was given a principal point 4.8 px too far right.
    const auto shifted = frame_of(80, 4.8);
    const CameraChange change = best_change({shifted}, {}, testing::TestRun(3));
    CHECK(change.shift_x == Approx(-0.03).margin(0.01));
    const auto [before, after] = compare_responses({shifted}, {}, change);
    CHECK(before == Approx(-1));
    CHECK(after > 35);

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

TEST_CASE("a focal length at the end of what was looked through is no advice")
{
    const auto told = [](double depth, double color)
    {
        Diagnosis diagnosis;
        diagnosis.depth_focal_scale = depth;
        diagnosis.color_change.focal_scale = color;
        std::vector<Finding> findings;
        tell_cameras(diagnosis, false, findings);
        REQUIRE(findings.size() == 1);
        return findings.front().text;
    };
    CHECK_THAT(told(1, 0.8), Catch::Contains("25 % too large: multiply it by 0.8"));
    CHECK_THAT(told(1, 0.763), Catch::Contains("31 % too large or more: was it calibrated for another picture size?"));
    CHECK_THAT(told(1.35, 1), Catch::Contains("26 % too small or more"));
    CHECK_THAT(told(1.25, 1), Catch::Contains("20 % too small: multiply it by 1.25"));
    CHECK_THAT(told(0.78, 0.78), Catch::Contains("both cameras") && Catch::Contains("or more"));
}
