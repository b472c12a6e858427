#include "catch.h"
#include "flat_charts_check.h"
#include "shapes.h"

#include <fresco/geometry/charts.h>
#include <fresco/geometry/map_charts.h>
#include <fresco/testing.h>

#include <atomic>
#include <limits>

using fresco::Mesh;
using namespace fresco::geometry;
using fresco::Vec2d;
using fresco::Vec3d;

namespace
{

/// Euler's number: 1 for a disk, one less for each hole.
long euler(const Disk& disk)
{
    Mesh mesh;
    mesh.positions.resize(disk.points.size());
    mesh.triangles = disk.triangles;
    const auto counts = count_surface(mesh);
    return static_cast<long>(counts.vertices) - static_cast<long>(counts.edges) + static_cast<long>(counts.faces);
}

}  // namespace

TEST_CASE("what is closed or has handles is cut open, a disk stays whole, and one with holes too")
{
    Mesh holed_torus = shapes::torus(8);
    holed_torus.triangles.resize(holed_torus.triangles.size() - 2);
    // The torus takes two cuts that cross. The Moebius strip has no outside: its faces disagree along one edge, where the surface
    // ends for us.
    for (const auto& [mesh, least_cuts, most_cuts, number] : {std::tuple{shapes::bent_sheet(6), 0U, 0U, 1},
                                                              {shapes::holed_sheet(), 0U, 0U, 1 - 2},
                                                              {shapes::torus(8), 16U, 99U, 1},
                                                              {holed_torus, 1U, 99U, 1},
                                                              {shapes::sphere(6, 8), 2U, 2U, 1},
                                                              {shapes::moebius_strip(20), 0U, 0U, 1}})
    {
        CAPTURE(mesh.triangles.size());
        const Disk disk = whole_disk(mesh);
        CHECK((disk.cut_edges >= least_cuts && disk.cut_edges <= most_cuts));
        CHECK(euler(disk) == number);
    }
}

namespace
{

FlatCharts one_chart(const Mesh& mesh)
{
    return seen_from_above(mesh, [](auto) { return 0u; });
}

MapCounts mapped(const Surface& surface, FlatCharts& flat, const DiskMap& map, int threads = 1)
{
    fresco::testing::TestRun progress(threads);
    return map_charts(surface, flat, map, 1e-6, progress);
}

/// The exact map of a piece of the cylinder of radius 1 around the y axis, three times too large.
std::optional<std::vector<Vec2d>> unroll(const Disk& disk, const std::vector<Vec2d>&)
{
    std::vector<Vec2d> places;
    for (const auto& p : disk.points)
        places.push_back({3 * std::atan2(p.x, p.z), 3 * p.y});
    return places;
}

}  // namespace

TEST_CASE("a folded vertex of a map is mended")
{
    const auto mesh = shapes::bent_sheet(12);
    const Surface surface(mesh);
    auto flat = one_chart(mesh);
    const auto counts = mapped(surface, flat,
                               [](const Disk& disk, const auto& projected)
                               {
                                   auto places = unroll(disk, projected);
                                   (*places)[6 * 13 + 6] = (*places)[6 * 13 + 8];
                                   return places;
                               });
    CHECK(counts.mapped_charts == 1);
    CHECK(counts.cut_off_faces == 0);
    CHECK(counts.mapped_area_share == Approx(1));
    CHECK(overlap_free(flat));
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        CHECK(share_of(surface, flat, f) > 0.9);
        CHECK(flat.projected[f] == 0);
    }
}

TEST_CASE("a chart that a map cannot lay as a whole is halved until it can")
{
    const auto mesh = shapes::bent_sheet(16);  // 512 faces
    const Surface surface(mesh);
    auto flat = one_chart(mesh);
    const auto limited = [](const Disk& disk, const auto& projected)
    { return disk.triangles.size() > 300 ? std::nullopt : unroll(disk, projected); };
    const auto counts = mapped(surface, flat, limited);
    CHECK(counts.halved_charts == 1);
    CHECK(counts.mapped_charts == 2);
    CHECK(flat.axes.size() == 2);
    CHECK(counts.mapped_area_share == Approx(1));
    CHECK(overlap_free(flat));
}

TEST_CASE("a map that comes back over itself is cut where it does")
{
    // A strip of 100 x 4 squares, laid out as a ring that closes after 60 of them.
    const auto mesh = fresco::testing::rectangle({}, {10, 0, 0}, {0, 0.4F, 0}, 100, 4);
    const Surface surface(mesh);
    auto flat = one_chart(mesh);
    const auto counts = mapped(
        surface, flat,
        [](const Disk& disk, const auto&)
        {
            std::vector<Vec2d> places;
            for (const auto& p : disk.points)
                places.push_back(Vec2d{std::cos(p.x), std::sin(p.x)} * (1.2 - p.y));
            return std::optional(places);
        },
        2);
    CHECK(counts.halved_charts == 1);
    CHECK(counts.mapped_charts == 2);
    CHECK(overlap_free(flat));
}

TEST_CASE("a map that is of no use leaves the projection as it was")
{
    const auto mesh = shapes::bent_sheet(16);
    const Surface surface(mesh);
    const auto before = one_chart(mesh);
    const auto nowhere = [](double value) {
        return [value](const Disk& disk, const auto&) {
            return std::optional(std::vector<Vec2d>(disk.points.size(), {value, 0}));
        };
    };
    const auto mirrored = [](const Disk& disk, const auto& projected)
    {
        auto places = unroll(disk, projected);
        for (auto& p : *places)
            p.x = -p.x;
        return places;
    };
    for (const DiskMap& map :
         {DiskMap(nowhere(0)), DiskMap(nowhere(std::numeric_limits<double>::quiet_NaN())), DiskMap(mirrored)})
    {
        auto flat = before;
        const auto counts = mapped(surface, flat, map);
        CHECK(counts.mapped_charts == 0);
        CHECK(counts.projected_charts == 1);
        CHECK(counts.halved_charts == 0);
        CHECK(flat.corners == before.corners);
        CHECK(flat.chart_of_face == before.chart_of_face);
    }
}
