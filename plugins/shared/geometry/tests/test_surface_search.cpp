#include "catch.h"

#include <fresco/geometry/surface_search.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::geometry;

namespace
{

std::array<Vec3d, 3> corners_of(const Mesh& mesh, std::uint32_t face)
{
    const auto& t = mesh.triangles[face];
    return {vec_cast<double>(mesh.positions[t[0]]), vec_cast<double>(mesh.positions[t[1]]),
            vec_cast<double>(mesh.positions[t[2]])};
}

/// The slow obvious way: every face.
SurfacePoint nearest_of_all(const Mesh& mesh, Vec3d p, const Vec3d* normal, double reach)
{
    SurfacePoint best;
    for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const auto c = corners_of(mesh, face);
        if (normal != nullptr && dot(cross(c[1] - c[0], c[2] - c[0]), *normal) <= 0)
            continue;
        const auto weights = nearest_weights(c, p);
        const Vec3d away = c[0] * weights[0] + c[1] * weights[1] + c[2] * weights[2] - p;
        if (dot(away, away) < best.squared_distance && dot(away, away) <= reach * reach)
            best = {face, weights, dot(away, away)};
    }
    return best;
}

double part(Random& random)
{
    return 2 * random.uniform() - 1;
}

Vec3f place(Random& random, bool on_grid)
{
    const Vec3d p{part(random), part(random), part(random)};
    // On a grid many distances are equal.
    return on_grid ? Vec3f{float(std::round(p.x * 2)), float(std::round(p.y * 2)), float(std::round(p.z * 2))}
                   : vec_cast<float>(p);
}

Mesh soup(std::size_t faces, bool on_grid)
{
    Random random{faces};
    Mesh mesh;
    for (std::uint32_t i = 0; i < faces; ++i)
    {
        const Vec3f middle = place(random, on_grid);
        for (int corner = 0; corner < 3; ++corner)
            mesh.positions.push_back(middle + place(random, on_grid) * (on_grid ? 1.0F : 0.2F));
        // Some faces are points.
        mesh.triangles.push_back(i % 5 == 4 ? Triangle{3 * i, 3 * i, 3 * i} : Triangle{3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

}  // namespace

TEST_CASE("the nearest point of a triangle is the nearest of a convex set")
{
    Random random{5};
    for (int trial = 0; trial < 3000; ++trial)
    {
        std::array<Vec3d, 3> c;
        for (Vec3d& corner : c)
            corner = {part(random), part(random), part(random)};
        const Vec3d p{2 * part(random), 2 * part(random), 2 * part(random)};
        const auto w = nearest_weights(c, p);
        CHECK(w[0] + w[1] + w[2] == Approx(1));
        CHECK(std::min({w[0], w[1], w[2]}) >= -1e-12);
        // No corner lies on the side of the nearest point that p is on.
        const Vec3d nearest = c[0] * w[0] + c[1] * w[1] + c[2] * w[2];
        for (const Vec3d corner : c)
            CHECK(dot(p - nearest, corner - nearest) < 1e-9);
    }
    const Vec3d end{4, 0, 0};
    CHECK(nearest_weights({Vec3d{}, end, end}, {1, 3, 0})[0] == 0.75);
}

TEST_CASE("the tree finds what a search of all faces finds, to the bit, and never the back of one")
{
    for (const bool on_grid : {false, true})
        for (const std::size_t faces : {1U, 4U, 5U, 40U, 700U})
        {
            const Mesh mesh = soup(faces, on_grid);
            const SurfaceSearch search(mesh);
            Random random{7};
            for (int trial = 0; trial < 400; ++trial)
            {
                const Vec3d p = vec_cast<double>(place(random, on_grid && trial % 2 == 0));
                const Vec3d normal{part(random), part(random), part(random)};
                const double reach = trial % 3 == 0 ? 0.3 : 100;
                const SurfacePoint any = search.nearest(p, reach);
                CHECK(any.face == nearest_of_all(mesh, p, nullptr, reach).face);
                const auto expected = nearest_of_all(mesh, p, &normal, reach);
                for (const std::uint32_t hint : {SurfacePoint::none, static_cast<std::uint32_t>(random.below(faces))})
                {
                    const auto found = search.nearest_facing(p, normal, reach, hint);
                    REQUIRE(found.face == expected.face);
                    if (found.found())
                        CHECK(found.squared_distance == expected.squared_distance);
                    CHECK(found.weights == expected.weights);
                }
            }
        }
}
