#include "catch.h"
#include "relaxation.h"
#include "shapes.h"

#include <fresco/geometry/flatten.h>

using namespace fresco;
using namespace fresco::geometry;

namespace
{

/// A mesh laid into the xy plane; vertices inside the unit square may move.
FlatPatch patch_of(const Mesh& mesh)
{
    FlatPatch patch;
    patch.triangles = mesh.triangles;
    for (const auto& t : mesh.triangles)
        for (const auto v : t)
            patch.points.push_back(vec_cast<double>(mesh.positions[v]));
    for (const auto& p : mesh.positions)
    {
        patch.places.push_back({p.x, p.y});
        patch.movable.push_back(p.x > 0 && p.x < 1 && p.y > 0 && p.y < 1);
    }
    return patch;
}

}  // namespace

TEST_CASE("folded vertices of a flat sheet go back to where every face has its true shape")
{
    const auto mesh = shapes::grid(5, [](float, float) { return 0.0F; });
    auto patch = patch_of(mesh);
    for (std::size_t v = 0; v < patch.places.size(); ++v)
        if (patch.movable[v])
            patch.places[v] = {0.5 + 0.4 * std::sin(7.0 * static_cast<double>(v)),
                               0.5 + 0.4 * std::cos(5.0 * static_cast<double>(v))};
    CHECK(relax(patch, 0).least_area_share < 0);

    const auto figures = relax(patch, 400);
    CHECK(figures.least_area_share == Approx(1).epsilon(0.02));
    CHECK(figures.square_stretch == Approx(1).epsilon(0.02));
    for (std::size_t v = 0; v < patch.places.size(); ++v)
        CHECK(length(patch.places[v] - Vec2d{mesh.positions[v].x, mesh.positions[v].y}) < 0.02);
}

TEST_CASE("a free triangle gets its true shape, a face without area harms nothing")
{
    FlatPatch patch;
    patch.triangles = {{0, 1, 2}, {2, 1, 1}};
    patch.points = {{0, 0, 5}, {1, 0, 5}, {0, 1, 6}, {0, 0, 5}, {0, 0, 5}, {0, 0, 5}};
    patch.places = {{0, 0}, {1, 0}, {0.3, -0.2}};
    patch.movable = {false, false, true};
    CHECK(relax(patch, 200).least_area_share == Approx(1).epsilon(1e-3));
    CHECK(relax(patch, 0).square_stretch == Approx(1).epsilon(1e-2));
    CHECK(patch.places[2].x == Approx(0).margin(1e-3));
    CHECK(patch.places[2].y == Approx(std::sqrt(2.0)).epsilon(1e-3));
}
