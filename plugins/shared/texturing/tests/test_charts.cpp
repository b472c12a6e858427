#include "catch.h"
#include <fresco/testing_scenes.h>

#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

using namespace fresco;
using namespace fresco::texturing;

TEST_CASE("charts end where the texcoords are cut, and seams join them, also where the mesh is split")
{
    Mesh mesh = testing::two_chart_wall();
    const Charts charts = find_charts(mesh);
    CHECK(charts.count == 2);
    CHECK(charts.of_face == std::vector<std::uint32_t>{0, 0, 1, 1});
    REQUIRE(charts.seams.size() == 1);
    const Seam& seam = charts.seams[0];
    CHECK(std::pair(seam.first_face, seam.second_face) == std::pair(0U, 3U));
    // Vertices 1 and 4 in the left chart, and in the right one.
    CHECK(std::ranges::equal(seam.first, std::array{Vec2f{0.4F, 0.1F}, Vec2f{0.4F, 0.4F}}));
    CHECK(std::ranges::equal(seam.second, std::array{Vec2f{0.9F, 0.4F}, Vec2f{0.9F, 0.1F}}));

    mesh.positions.push_back(mesh.positions[1]);
    mesh.positions.push_back(mesh.positions[4]);
    mesh.triangles[2] = {6, 2, 5};
    mesh.triangles[3] = {6, 5, 7};
    CHECK(find_charts(mesh).of_face == charts.of_face);
    CHECK(find_charts(mesh).seams.size() == 1);
}

TEST_CASE("a texel that a face touches has its center's place on the face's plane")
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    // Corners at texel coordinates (1.2, 8.8), (6.2, 8.8), (1.2, 3.8) of a 10 x 10 texture, y down.
    mesh.texcoords = {{0.12F, 0.12F}, {0.62F, 0.12F}, {0.12F, 0.62F}};
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), 10, Progress());
    CHECK(texel_position(mesh, faces, 85).x == Approx((5.5 - 1.2) / 5));  // texel (5, 8)
    CHECK(texel_position(mesh, faces, 85).y == Approx((8.8 - 8.5) / 5));
}

TEST_CASE("faces of any shape own the texels that testing every texel gives them")
{
    constexpr int size = 90;
    Random random(3);
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const auto draw = [&] { return Vec2f{static_cast<float>(random.uniform()), static_cast<float>(random.uniform())}; };
    for (int i = 0; i < 400; ++i)
    {
        // Large and small ones, slivers, sides along the rows or nearly so, corners on the texels' borders, no area at all.
        const float reach = i % 3 == 0 ? 0.4F : 0.03F;
        Vec2f a = draw();
        if (i % 7 == 0)
            a = {std::round(a.x * size) / size, (std::round(a.y * size) + 0.5F * static_cast<float>(i % 2)) / size};
        Vec2f b = a + draw() * reach;
        Vec2f c = a - draw() * reach;
        if (i % 4 == 1)
            b.y = a.y + (i % 8 == 1 ? 0 : 1e-7F);
        if (i % 5 == 2)
            c = a + (b - a) * 0.7F;
        if (i % 5 == 3)
            c = c + (b - c) * 0.999F;
        mesh.triangles.push_back({0, 1, 2});
        for (const Vec2f uv : {a, b, c})
            mesh.texcoords.push_back({std::clamp(uv.x, 0.0F, 1.0F), std::clamp(uv.y, 0.0F, 1.0F)});
    }
    Charts charts;
    charts.count = 1;
    charts.of_face.assign(mesh.triangles.size(), 0);
    const TexelFaces found = find_texel_faces(mesh, charts, size, testing::TestRun(2));

    std::size_t different = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            std::uint32_t holding = TexelFaces::none;
            std::uint32_t touching = TexelFaces::none;
            for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
            {
                std::array<Vec2d, 3> corners;
                for (std::size_t i = 0; i < 3; ++i)
                {
                    const Vec2f uv = mesh.texcoords[3 * face + i];
                    corners[i] = {double{uv.x} * size, (1 - double{uv.y}) * size};
                }
                if (cross(corners[1] - corners[0], corners[2] - corners[0]) < 0)
                    std::swap(corners[1], corners[2]);
                const auto is_near = [&](double half_side)
                {
                    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
                    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
                    const auto texel = [](double at) { return std::clamp(std::floor(at), 0.0, size - 1.0); };
                    if (x < texel(left) || x > texel(right) || y < texel(top) || y > texel(bottom))
                        return false;
                    for (std::size_t i = 0; i < 3; ++i)
                    {
                        const Vec2d side = corners[(i + 1) % 3] - corners[i];
                        const Vec2d to = Vec2d{x + 0.5, y + 0.5} - corners[i];
                        if (cross(side, to) + half_side * (std::abs(side.x) + std::abs(side.y)) < 0)
                            return false;
                    }
                    return true;
                };
                if (holding == TexelFaces::none && is_near(0))
                    holding = face;
                if (touching == TexelFaces::none && is_near(0.5))
                    touching = face;
            }
            const auto texel = static_cast<std::size_t>(y * size + x);
            different += found.face[texel] != (holding != TexelFaces::none ? holding : touching);
            different += (found.inside[texel] != 0) != (holding != TexelFaces::none);
        }
    CHECK(different == 0);
}

TEST_CASE("links cross a seam at the same surface points, in both directions")
{
    const Mesh mesh = testing::two_chart_wall();
    const Charts charts = find_charts(mesh);
    const TexelFaces faces = find_texel_faces(mesh, charts, 40, Progress());
    const auto links = seam_links(charts, faces);
    CHECK(links.size() >= 2 * 12);
    for (const auto& [a, b] : links)
    {
        CHECK(std::binary_search(links.begin(), links.end(), std::pair(b, a)));
        CHECK(charts.of_face[faces.face[a]] != charts.of_face[faces.face[b]]);
        const Vec3f apart = texel_position(mesh, faces, a) - texel_position(mesh, faces, b);
        CHECK(length(apart) < 2.1F / 12);  // two texels of 1/12 m
    }
}

namespace
{

/// Returns check_layout's problem with a wall in two charts, the right one at the texcoords that `place` gives.
std::string layout_problem(const std::function<Vec2f(Vec2f)>& place)
{
    Mesh mesh = testing::two_chart_wall();
    for (std::size_t corner = 6; corner < 12; ++corner)
        mesh.texcoords[corner] = place(mesh.texcoords[corner]);
    testing::TestRun run;
    const std::string error = testing::error_of([&] { check_layout(mesh, "the test's mesh", run); });
    return !error.empty() ? "error: " + error : run.messages.empty() ? "" : run.messages.front();
}

}  // namespace

TEST_CASE("an atlas is refused where charts lie on each other or have no room, by the share of the surface")
{
    CHECK(layout_problem([](Vec2f uv) { return uv; }).empty());
    // The charts are 0.3 wide, from 0.1 and from 0.6.
    CHECK(layout_problem(
              [](Vec2f uv) {
                  return uv - Vec2f{0.35F, 0};
              }) == "error: 50 % of the surface of the test's mesh lies on other parts in the atlas and would show their paint; "
                    "the way on is a new atlas (atlas.project)");
    CHECK_THAT(layout_problem(
                   [](Vec2f uv) {
                       return uv - Vec2f{0.206F, 0};
                   }),
               Catch::StartsWith("warning: 2 % of the surface of the test's mesh lies on other parts"));
    CHECK(layout_problem([](Vec2f uv) { return uv - Vec2f{0.2F, 0}; }).empty());
    CHECK_THAT(layout_problem(
                   [](Vec2f uv) {
                       return Vec2f{uv.x, 0.25F};
                   }),
               Catch::StartsWith("error: 50 % of the surface of the test's mesh has no room in the atlas"));
    // Half a model that shares the texture of the other, and faces that are there twice.
    CHECK(layout_problem([](Vec2f uv) { return Vec2f{1 - uv.x, uv.y}; }).empty());
    Mesh twice = testing::two_chart_wall();
    testing::append(twice, testing::two_chart_wall());
    testing::TestRun run;
    check_layout(twice, "the test's mesh", run);
    CHECK(run.messages.empty());
}

TEST_CASE("the layout of thousands of faces on each other is measured by few texels")
{
    Mesh mesh;
    for (int i = 0; i < 20'000; ++i)
        testing::append(mesh, testing::wall(1, static_cast<float>(i)));
    testing::TestRun run;
    // Centers on the diagonal, where the two faces of a wall meet, are not counted.
    CHECK_THROWS_WITH(check_layout(mesh, "the test's mesh", run), Catch::StartsWith("96 %"));
}
