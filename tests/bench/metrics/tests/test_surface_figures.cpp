#include "catch.h"
#include "shapes.h"
#include "surface_figures.h"

#include <fresco/random.h>

#include <limits>

using namespace fresco;
using namespace bench;

namespace
{

Mesh plane(float z)
{
    return shapes::grid(10, [z](float, float) { return z; });
}

}  // namespace

TEST_CASE("figures of distances: mean, the value that 99 of 100 do not exceed, the largest")
{
    std::vector<double> values;
    for (int i = 1; i <= 100; ++i)
        values.push_back(i);
    const auto figures = distance_figures(values);
    CHECK(figures.mean == Approx(50.5));
    CHECK(figures.p99 == 99);
    CHECK(figures.largest == 100);
    CHECK(distance_figures({}).largest == 0);
    CHECK(distance_figures({7}).p99 == 7);
}

TEST_CASE("samples are as likely everywhere, and the same for the same seed")
{
    // The left square is two faces, the right one of the same area is 200.
    Mesh mesh = shapes::grid(1, [](float, float) { return 0.0F; });
    auto fine = plane(0);
    for (auto& p : fine.positions)
        p.x += 1;
    shapes::append(mesh, fine);
    const auto points = surface_samples(mesh, 20'000, 3);
    REQUIRE(points.size() == 20'000);
    CHECK(points == surface_samples(mesh, 20'000, 3));
    int left = 0;
    int corner = 0;
    for (const auto& p : points)
    {
        left += p.x < 1;
        corner += p.x < 0.5 && p.y < 0.5;
    }
    CHECK(left == Approx(10'000).margin(300));
    CHECK(corner == Approx(2500).margin(200));
}

TEST_CASE("two planes are as far apart as they are")
{
    const auto same = surface_distance(plane(0), plane(0), 1000, 1, 2).both();
    CHECK(same.largest < 1e-7);
    const auto apart = surface_distance(plane(0.25F), plane(0), 1000, 1, 2).both();
    CHECK(apart.mean == Approx(0.25));
    CHECK(apart.p99 == Approx(0.25));
    const auto border = border_distance(plane(0.25F), plane(0), 1000, 1, 2).both();
    CHECK(border.mean == Approx(0.25));
}

TEST_CASE("what is lost is seen from the reference, what is added from the result")
{
    const auto whole = plane(0);
    Mesh half = whole;
    half.triangles.resize(half.triangles.size() / 2);  // y < 0.5
    const auto lost = surface_distance(half, whole, 20'000, 1, 2);
    CHECK(lost.to_reference.largest < 1e-7);
    CHECK(lost.from_reference.mean == Approx(0.125).epsilon(0.05));  // half the points, 0.25 on average
    CHECK(lost.from_reference.largest == Approx(0.5).epsilon(0.01));
    const auto added = surface_distance(whole, half, 20'000, 1, 2);
    CHECK(added.to_reference.mean == lost.from_reference.mean);
    // The border at y = 1 moved to y = 0.5; the upper halves of the sides are gone.
    const auto border = border_distance(half, whole, 20'000, 1, 2);
    CHECK(border.from_reference.largest == Approx(0.5).epsilon(0.01));
    CHECK(border.to_reference.largest == Approx(0.5).epsilon(0.01));  // the new border's middle
}

TEST_CASE("a cube has no border, and one without a side differs by it")
{
    const auto cube = shapes::box({0, 0, 0}, {1, 1, 1});
    CHECK(border_distance(cube, cube, 100, 1, 1).both().largest == 0);
    auto open = cube;
    open.triangles.resize(10);
    CHECK(border_distance(open, cube, 100, 1, 1).both().mean == std::numeric_limits<double>::infinity());
    // A sixth of the surface, on average a third of a half from the nearest edge.
    CHECK(surface_distance(open, cube, 60'000, 1, 2).from_reference.mean == Approx(1.0 / 36).epsilon(0.05));
}

TEST_CASE("flipped, flat and non-manifold faces are counted")
{
    const auto reference = plane(0);
    CHECK(face_faults(reference, reference, 2).flipped == 0);
    auto mesh = reference;
    std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
    mesh.triangles.push_back({0, 1, 1});
    const auto faults = face_faults(mesh, reference, 2);
    CHECK(faults.flipped == 1);
    CHECK(faults.degenerate == 1);
    CHECK(faults.non_manifold_edges_created > 0);  // the turned face disagrees with its neighbors

    auto fin = reference;
    fin.positions.push_back({0.05F, 0.05F, 1});
    const auto& t = fin.triangles[0];  // its diagonal has two faces already
    fin.triangles.push_back({t[1], t[2], static_cast<std::uint32_t>(fin.positions.size() - 1)});
    CHECK(face_faults(fin, reference, 2).non_manifold_edges_created == 1);
    CHECK(face_faults(reference, fin, 2).non_manifold_edges_created == -1);
}
