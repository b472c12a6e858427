#include "catch.h"
#include "flat_charts_check.h"
#include "shapes.h"

#include <fresco/geometry/flatten.h>

using namespace fresco::geometry;
using namespace fresco;

namespace
{

/// Every face a chart of its own, laid flat by turning its first edge onto the x axis.
FlatCharts each_alone(const Surface& surface)
{
    FlatCharts flat;
    const auto& mesh = surface.mesh;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const auto at = [&](std::size_t k) { return vec_cast<double>(mesh.positions[mesh.triangles[f][k]]); };
        const Vec3d along = normalized(at(1) - at(0));
        const Vec3d up = cross(surface.normals[f], along);
        flat.chart_of_face.push_back(f);
        flat.axes.push_back(surface.normals[f]);
        flat.projected.push_back(1);
        for (std::size_t k = 0; k < 3; ++k)
            flat.corners.push_back({dot(at(k) - at(0), along), dot(at(k) - at(0), up)});
    }
    return flat;
}

Vec2d corner_at(const Mesh& mesh, const FlatCharts& flat, std::uint32_t face, std::uint32_t vertex)
{
    const auto corner = std::ranges::find(mesh.triangles[face], vertex) - mesh.triangles[face].begin();
    return flat.corners[3 * std::size_t{face} + static_cast<std::size_t>(corner)];
}

/// Edges between two faces of one chart where their corners differ.
std::size_t open_edges(const Surface& surface, const FlatCharts& flat)
{
    std::size_t open = 0;
    for (std::uint32_t f = 0; f < surface.areas.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto g = surface.neighbors[f][k]; g != none && g > f && flat.chart_of_face[f] == flat.chart_of_face[g])
            {
                const auto& t = surface.mesh.triangles[f];
                open += std::ranges::any_of(
                    std::array{t[k], t[(k + 1) % 3]}, [&](std::uint32_t v)
                    { return length(corner_at(surface.mesh, flat, f, v) - corner_at(surface.mesh, flat, g, v)) > 1e-6; });
            }
    return open;
}

}  // namespace

TEST_CASE("a box of crumbs unrolls into one net that keeps its area")
{
    const Mesh mesh = shapes::box({0, 0, 0}, {1, 1, 1});
    const Surface surface(mesh);
    FlatCharts flat = each_alone(surface);
    // Charts of many texels are no crumbs.
    CHECK(attach_crumbs(surface, flat, 0.01, {}) == 0);
    CHECK(flat.corners == each_alone(surface).corners);
    CHECK(attach_crumbs(surface, flat, 1, {}) == 11);
    CHECK(charts_of(flat) == 1);
    CHECK(open_edges(surface, flat) == 18 - 11);
    CHECK(overlap_free(flat, 1e-3));
    double area = 0;
    for (std::size_t f = 0; f < 12; ++f)
        area += 0.5 * cross(flat.corners[3 * f + 1] - flat.corners[3 * f], flat.corners[3 * f + 2] - flat.corners[3 * f]);
    CHECK(area == Approx(6));
}

TEST_CASE("a crumb of which the edge is much shorter in the neighbor's plane stays away")
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
    const Surface surface(mesh);
    for (const double scale : {0.7, 0.9, 1.2, 1.4})
    {
        FlatCharts flat = each_alone(surface);
        for (std::size_t k = 0; k < 3; ++k)
            flat.corners[k] = flat.corners[k] * scale;
        CHECK(attach_crumbs(surface, flat, 1, {}) == (scale > 0.8 && scale < 1.25 ? 1 : 0));
    }
}

namespace
{

/// A plane with a fin: three vertices of the middle line stand up, so that the faces around them have no area from above.
Mesh finned_plane()
{
    auto mesh = shapes::grid(12, [](float, float) { return 0.0F; });
    for (const std::uint32_t x : {5u, 6u, 7u})
        mesh.positions[6 * 13 + x] += Vec3f{0, 1.0F / 12, 0.06F};
    return mesh;
}

bool stands(const Mesh& mesh, std::uint32_t face)
{
    return area_vector(mesh, face).z <= 0.3 * length(area_vector(mesh, face));
}

}  // namespace

TEST_CASE("a fin inside a chart goes into it with all its edges; what is far from it stays, and so does a cut beside it")
{
    const auto mesh = finned_plane();
    const Surface surface(mesh);
    for (const bool is_slit : {false, true})
    {
        auto flat = seen_from_above(mesh, [&](auto f) { return stands(mesh, f) ? 1u : 0u; });
        // A slit that begins at the fin: what is to its right moves a little further.
        const std::uint32_t middle = 8 * 13 + 6;
        for (std::uint32_t f = 0; is_slit && f < mesh.triangles.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
                if (mesh.triangles[f][k] == middle && std::ranges::any_of(mesh.triangles[f], [](auto v) { return v % 13 > 6; }))
                    flat.corners[3 * std::size_t{f} + k].x += 0.02;
        const auto fin = static_cast<std::size_t>(std::ranges::count(flat.chart_of_face, 1u));
        const auto before = flat;
        CHECK(join_crumbs(surface, flat, 0.02, {}) == 1);
        CHECK(charts_of(flat) == 1);
        CHECK(flat.unfolded_faces == fin);
        CHECK(open_edges(surface, flat) == (is_slit ? 2 : 0));
        CHECK(overlap_free(flat));
        for (std::size_t f = 0; f < surface.areas.size(); ++f)
            CHECK(share_of(surface, flat, f) >= 0.05);
        CHECK(std::equal(flat.corners.begin(), flat.corners.begin() + 72, before.corners.begin()));  // the first row
        CHECK(flat.projected[0] == 1);
    }
}

TEST_CASE("one face as large as a room beside thousands of small ones takes no longer")
{
    Mesh mesh = testing::rectangle({}, {1e-3F, 0, 0}, {0, 1e-3F, 0}, 200, 200);
    shapes::append(mesh, testing::rectangle({}, {100, 0, 0}, {0, 100, 0}));
    const Surface surface(mesh);
    auto flat = seen_from_above(mesh, [&](auto f) { return f + 2 >= mesh.triangles.size() ? 1u : 0u; });
    CHECK(join_crumbs(surface, flat, 1e-5, {}) == 0);
    CHECK(attach_crumbs(surface, flat, 1e-5, {}) == 0);
}
