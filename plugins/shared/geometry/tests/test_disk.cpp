#include "catch.h"
#include "shapes.h"

#include <fresco/geometry/charts.h>
#include <fresco/numerics/numerics.h>

#include <numeric>
#include <set>

using fresco::Mesh;
using namespace fresco::geometry;

namespace
{

std::vector<std::uint32_t> all_faces(const Mesh& mesh)
{
    std::vector<std::uint32_t> faces(mesh.triangles.size());
    std::iota(faces.begin(), faces.end(), 0u);
    return faces;
}

/// Euler's number and the count of closed border lines: 1 and 1 for a disk.
std::pair<long, std::size_t> shape_of(const Disk& disk)
{
    Mesh mesh;
    for (const auto& p : disk.points)
        mesh.positions.push_back(fresco::vec_cast<float>(p));
    mesh.triangles = disk.triangles;
    const auto counts = count_surface(mesh);
    fresco::numerics::DisjointSets lines(disk.points.size());
    std::set<std::uint32_t> on_border;
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t low, std::uint32_t high, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() == 1)
                      {
                          lines.join(low, high);
                          on_border.insert({low, high});
                      }
                  });
    std::set<std::uint32_t> roots;
    for (const auto v : on_border)
        roots.insert(lines.find(v));
    return {static_cast<long>(counts.vertices) - static_cast<long>(counts.edges) + static_cast<long>(counts.faces), roots.size()};
}

using Shape = std::pair<long, std::size_t>;

}  // namespace

TEST_CASE("a disk stays whole, and one with holes too")
{
    const auto sheet = shapes::bent_sheet(6);
    const auto whole = cut_to_disk(Surface(sheet), all_faces(sheet));
    CHECK(whole.cut_edges == 0);
    CHECK(whole.points.size() == sheet.positions.size());
    CHECK(shape_of(whole) == Shape{1, 1});

    const auto holed = shapes::holed_sheet();
    const auto kept = cut_to_disk(Surface(holed), all_faces(holed));
    CHECK(kept.cut_edges == 0);
    CHECK(shape_of(kept) == Shape{2 - 3, 3});
}

TEST_CASE("what is closed or has handles is cut open")
{
    const auto torus = shapes::torus(8);
    const auto opened = cut_to_disk(Surface(torus), all_faces(torus));
    CHECK(opened.cut_edges >= 16);  // two cuts that cross
    CHECK(shape_of(opened) == Shape{1, 1});

    auto holed_torus = torus;
    holed_torus.triangles.resize(holed_torus.triangles.size() - 2);
    const auto handle = cut_to_disk(Surface(holed_torus), all_faces(holed_torus));
    CHECK(handle.cut_edges > 0);
    CHECK(shape_of(handle) == Shape{1, 1});

    const auto ball = shapes::sphere(6, 8);
    const auto open = cut_to_disk(Surface(ball), all_faces(ball));
    CHECK(open.cut_edges == 2);
    CHECK(shape_of(open) == Shape{1, 1});

    // No outside: its faces disagree along one edge, where the surface ends for us.
    const auto band = shapes::moebius_strip(20);
    const auto strip = cut_to_disk(Surface(band), all_faces(band));
    CHECK(strip.cut_edges == 0);
    CHECK(shape_of(strip) == Shape{1, 1});
}
