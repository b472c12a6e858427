#include "catch.h"
#include "holes.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace fresco;

namespace
{

/// Without the faces whose middle `is_gone`.
template <class Gone>
Mesh without(Mesh mesh, const Gone& is_gone)
{
    std::erase_if(mesh.triangles, [&](const Triangle& t)
                  { return is_gone((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) * (1.0F / 3)); });
    return mesh;
}

/// Half a cylinder of radius 1 m and length 2 m along y, from x = -1 over z = 1 to x = 1.
Mesh vault(std::uint32_t n)
{
    Mesh mesh = testing::grid(n, [](float, float) { return 0.0F; });
    for (Vec3f& p : mesh.positions)
    {
        const float angle = std::numbers::pi_v<float> * p.x;
        p = {-std::cos(angle), 2 * p.y, std::sin(angle)};
    }
    return mesh;
}

/// The edges of one face. Checks that all faces show the same side.
std::size_t border_edges(const Mesh& mesh)
{
    const auto counts = geometry::count_surface(mesh);
    CHECK(counts.complex_edges == 0);
    return counts.border_edges;
}

Mesh closed_mesh(const Mesh& mesh, double max_width_m, HoleFigures& figures)
{
    Progress progress;
    return with_patches(mesh, hole_patches(mesh, max_width_m, progress, figures), figures);
}

const auto in_middle = [](Vec3f p) { return std::abs(p.x - 0.5F) < 0.1F && std::abs(p.y - 0.5F) < 0.1F; };

/// A plane with a hole in its middle.
struct HolesTest
{
    Mesh holed = without(testing::grid(40, [](float, float) { return 0.0F; }), in_middle);
    HoleFigures figures;
};

}  // namespace

TEST_CASE_METHOD(HolesTest,
                 "a hole in a plane is closed flat, with faces as large as those around, and the plane's own border stays")
{
    const Mesh closed = closed_mesh(holed, 0.3, figures);
    CHECK(figures.closed == 1);
    CHECK(figures.too_large == 1);
    CHECK(figures.faces_added == closed.triangles.size() - holed.triangles.size());
    CHECK(figures.faces_added > 30);
    CHECK(figures.area_m2 == Approx(0.04).epsilon(1e-5));
    CHECK(border_edges(closed) == 160);
    for (const Vec3f& p : closed.positions)
        CHECK(std::abs(p.z) < 1e-6F);
    CHECK(std::equal(holed.triangles.begin(), holed.triangles.end(), closed.triangles.begin()));
}

TEST_CASE_METHOD(HolesTest, "a patch bends on as the surface around it")
{
    const Mesh holed = without(vault(60), [](Vec3f p) { return p.z > 0.97F && std::abs(p.y - 1) < 0.2F; });
    const Mesh closed = closed_mesh(holed, 1, figures);
    REQUIRE(figures.closed == 1);
    CHECK(border_edges(closed) == border_edges(vault(60)));
    double apart = 0;
    for (std::size_t i = holed.positions.size(); i < closed.positions.size(); ++i)
        apart = std::max(apart, std::abs(std::hypot(double{closed.positions[i].x}, double{closed.positions[i].z}) - 1));
    CHECK(apart < 0.003);  // A flat one would lie 0.03 below.
}

TEST_CASE_METHOD(HolesTest, "wide holes, loops around small pieces and edges of many faces stay as they are")
{
    HoleFigures wide;
    CHECK(closed_mesh(holed, 0.2, wide).triangles.size() == holed.triangles.size());
    CHECK(wide.too_large == 2);

    HoleFigures piece;
    CHECK(closed_mesh(testing::wall(0.1F), 1, piece).triangles.size() == 2);
    CHECK(piece.outer == 1);

    Mesh fins = testing::grid(2, [](float, float) { return 0.0F; });
    fins.positions.push_back({0.5F, 0.5F, 1});
    const Triangle first = fins.triangles.front();
    for (std::size_t k = 0; k < 3; ++k)
        fins.triangles.push_back({first[k], first[(k + 1) % 3], 9});
    HoleFigures many;
    CHECK_NOTHROW(closed_mesh(fins, 0.01, many));
    CHECK(many.closed == 0);
}

TEST_CASE_METHOD(HolesTest, "two holes that meet at a vertex are closed each, with colors from around")
{
    Mesh holed =
        without(testing::grid(10, [](float, float) { return 0.0F; }),
                [](Vec3f p)
                {
                    const auto in = [&](float x, float y) { return p.x > x && p.x < x + 0.2F && p.y > y && p.y < y + 0.2F; };
                    return in(0.3F, 0.3F) || in(0.5F, 0.5F);
                });
    for (const Vec3f& p : holed.positions)
        holed.colors.push_back({static_cast<std::uint8_t>(std::lround(200 * p.x)), 90, 0});
    const Mesh closed = closed_mesh(holed, 0.35, figures);
    CHECK(figures.closed == 2);
    CHECK(border_edges(closed) == 40);
    REQUIRE(closed.colors.size() == closed.positions.size());
    for (std::size_t i = holed.positions.size(); i < closed.positions.size(); ++i)
    {
        CHECK(closed.colors[i][1] == 90);
        CHECK(std::abs(closed.colors[i][0] - 200 * closed.positions[i].x) < 25);
    }
}

TEST_CASE_METHOD(HolesTest, "a hole that cameras looked through stays open, one that they did not look into is closed")
{
    Camera camera = testing::camera(64, 64, 64, {0.5, 0.5, -1});
    const auto figures_at = [&](float depth_m)
    {
        HoleFigures figures;
        Progress progress;
        std::vector<HolePatch> patches = hole_patches(holed, 0.3, progress, figures);
        judge(patches, camera, RasterF(64, 64, 1, depth_m));
        (void)with_patches(holed, patches, figures);
        return figures;
    };
    CHECK(figures_at(2).openings == 1);
    CHECK(figures_at(2).closed == 0);
    CHECK(figures_at(1.01F).closed == 1);  // Measured where the patch lies,
    CHECK(figures_at(0.5F).closed == 1);   // before it,
    CHECK(figures_at(0).closed == 1);      // or not at all.
    camera.world_from_camera.translation = {9, 9, -1};
    CHECK(figures_at(2).closed == 1);
}
