#include "catch.h"
#include "flat_charts_check.h"
#include "shapes.h"

#include <fresco/geometry/flatten.h>

using namespace fresco::geometry;
using fresco::Vec2d;

TEST_CASE("overlap depth of triangles that can be measured by hand")
{
    const std::array<Vec2d, 3> t{Vec2d{0, 0}, {1, 0}, {0, 1}};
    const auto depth = [](std::array<Vec2d, 3> a, std::array<Vec2d, 3> b) { return overlap_depth(a, b); };
    CHECK(depth(t, {Vec2d{1, 0}, {1, 1}, {0, 1}}) == Approx(0).margin(1e-12));  // a common edge
    CHECK(depth(t, {Vec2d{2, 0}, {3, 0}, {2, 1}}) == 0);                        // apart
    CHECK(depth(t, {Vec2d{0.9, -1}, {2, -1}, {0.9, 1}}) == Approx(0.1));        // a corner cut off
    CHECK(depth(t, t) > 0.5);                                                   // itself
    CHECK(depth(t, {Vec2d{0, 0}, {0, 1}, {1, 0}}) > 0.5);                       // itself turned over
    CHECK(depth(t, {Vec2d{0.2, 0.2}, {0.3, 0.2}, {0.2, 0.3}}) > 0.1);           // one inside
}

TEST_CASE("the grid finds exactly the pairs that trying all pairs finds")
{
    auto mesh = shapes::grid(12, [](float, float) { return 0.0F; });
    shapes::shake(mesh, 0.055F, 3);  // two thirds of an edge: many folds
    Corners corners;
    std::vector<std::uint32_t> faces;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
    {
        faces.push_back(f);
        for (const auto v : mesh.triangles[f])
            corners.push_back({mesh.positions[v].x, mesh.positions[v].y});
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
    for (std::uint32_t a = 0; a < faces.size(); ++a)
        for (std::uint32_t b = a + 1; b < faces.size(); ++b)
            if (overlap_depth(std::span<const Vec2d, 3>(&corners[3 * a], 3), std::span<const Vec2d, 3>(&corners[3 * b], 3)) >
                1e-6)
                all.emplace_back(a, b);
    CHECK(all.size() > 50);
    CHECK(find_overlaps(corners, faces, 1e-6) == all);

    const Surface surface(mesh);
    const auto kept = injective_part(surface, corners, faces, {0, 0, 1}, 1e-6);
    CHECK(kept.size() > faces.size() / 4);
    CHECK(kept.size() < faces.size());
    CHECK(find_overlaps(corners, kept, 1e-6).empty());
}

TEST_CASE("a helix that passes over itself is cut")
{
    // A ramp of two and a half turns: every face looks up, so one cone holds all, but the turns lie above each other.
    auto mesh = fresco::testing::rectangle({1, 0, 0}, {1, 0, 0}, {0, 15.7F, 0}, 1, 100);
    for (auto& [radius, angle, z] : mesh.positions)
        std::tie(radius, angle, z) = std::tuple(radius * std::cos(angle), radius * std::sin(angle), angle / 7.85F);
    const Surface surface(mesh);
    fresco::Progress progress;
    const FlattenOptions usual{.charts = {.angle_limit_deg = 70, .merge_limit_deg = 80}, .texel_m = 0.001};
    const auto partition = cut_into_charts(surface, usual.charts, progress);
    REQUIRE(partition.axes.size() == 1);
    const auto flat = project_charts(surface, partition, usual, progress);
    CHECK(flat.axes.size() == 3);
    CHECK(overlap_free(flat));
}
