#include "catch.h"
#include "flat_charts_check.h"
#include "shapes.h"

#include <fresco/geometry/flatten.h>
#include <fresco/numerics/disjoint_sets.h>

#include <cmath>
#include <set>

using namespace fresco;
using namespace fresco::geometry;

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
    flat.count = flat.axes.size();
    return flat;
}

/// A chart's faces hang together by edges whose corners agree in the plane.
bool connected(const Surface& surface, const FlatCharts& flat)
{
    numerics::DisjointSets sets(flat.chart_of_face.size());
    for (std::uint32_t f = 0; f < flat.chart_of_face.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = surface.neighbors[f][k];
            if (g == none || flat.chart_of_face[g] != flat.chart_of_face[f])
                continue;
            bool agree = true;
            for (const std::size_t end : {k, (k + 1) % 3})
                for (std::size_t other = 0; other < 3; ++other)
                    if (surface.mesh.triangles[g][other] == surface.mesh.triangles[f][end])
                        agree = agree && length(flat.corners[3 * g + other] - flat.corners[3 * f + end]) < 1e-6;
            if (agree)
                sets.join(f, g);
        }
    std::set<std::uint32_t> roots;
    for (std::uint32_t f = 0; f < flat.chart_of_face.size(); ++f)
        roots.insert(sets.find(f));
    return roots.size() == charts_of(flat);
}

}  // namespace

TEST_CASE("a box of crumbs unrolls into one net that keeps its area")
{
    const Mesh mesh = shapes::box({0, 0, 0}, {1, 1, 1});
    const Surface surface(mesh);
    FlatCharts flat = each_alone(surface);
    CHECK(attach_crumbs(surface, flat, 1, {}) == 11);
    CHECK(charts_of(flat) == 1);
    CHECK(connected(surface, flat));
    CHECK(overlap_free(flat, 1e-3));
    double area = 0;
    for (std::size_t f = 0; f < 12; ++f)
        area += 0.5 * cross(flat.corners[3 * f + 1] - flat.corners[3 * f], flat.corners[3 * f + 2] - flat.corners[3 * f]);
    CHECK(area == Approx(6));
}

TEST_CASE("what is no crumb stays: many texels")
{
    const Mesh mesh = shapes::box({0, 0, 0}, {1, 1, 1});
    const Surface surface(mesh);
    FlatCharts flat = each_alone(surface);
    const Corners before = flat.corners;
    CHECK(attach_crumbs(surface, flat, 0.01, {}) == 0);
    CHECK(charts_of(flat) == 12);
    CHECK(before == flat.corners);
}

TEST_CASE("a noisy surface of crumbs joins into few charts without overlaps")
{
    const Mesh mesh = shapes::noisy_corner(12);
    const Surface surface(mesh);
    FlatCharts flat = each_alone(surface);
    const std::size_t before = charts_of(flat);
    const std::size_t placed = attach_crumbs(surface, flat, 0.01, {});
    CHECK(charts_of(flat) == before - placed);
    CHECK(placed > before / 2);
    CHECK(connected(surface, flat));
    CHECK(overlap_free(flat, 1e-5));
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
