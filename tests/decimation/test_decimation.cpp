#include "catch.h"
#include "decimate.h"
#include "decimate_openmesh.h"
#include "shapes.h"
#include "surface_samples.h"

#include <fresco/geometry/repair.h>

using fresco::Mesh;

namespace
{

/// Border edges as triangles that name their end twice.
Mesh border_of(const Mesh& mesh)
{
    Mesh result;
    result.positions = mesh.positions;
    fresco::geometry::for_each_edge(mesh.triangles, mesh.positions.size(),
                                    [&](std::uint32_t low, std::uint32_t high, auto uses)
                                    {
                                        if (uses.size() == 1)
                                            result.triangles.push_back({low, high, high});
                                    });
    return result;
}

/// Distance of a mesh's border vertices to the border of a simplified one.
double border_distance(const Mesh& result, const Mesh& mesh)
{
    const Mesh border = border_of(result);
    const fresco::geometry::SurfaceSearch search(border);
    double sum = 0;
    for (const auto& edge : border_of(mesh).triangles)
        sum += std::sqrt(search.nearest(fresco::vec_cast<double>(mesh.positions[edge[0]])).squared_distance);
    return sum;
}

/// Faces that look against the surface below their middles.
std::size_t flipped_faces(const Mesh& result, const Mesh& mesh)
{
    const fresco::geometry::SurfaceSearch below(mesh);
    std::size_t flipped = 0;
    for (std::size_t f = 0; f < result.triangles.size(); ++f)
    {
        fresco::Vec3d middle;
        for (const auto v : result.triangles[f])
            middle += fresco::vec_cast<double>(result.positions[v]) * (1.0 / 3);
        const auto normal = fresco::geometry::area_vector(result, f);
        CHECK(length(normal) > 0);
        flipped += dot(normal, fresco::geometry::area_vector(mesh, below.nearest(middle).face)) < 0 ? 1 : 0;
    }
    return flipped;
}

}  // namespace

TEST_CASE("optimal points are nearer to the surface than points of the mesh, at the surface and at its borders")
{
    fresco::Progress progress;
    fresco::geometry::RepairReport report;
    const Mesh mesh = fresco::geometry::repaired(shapes::noisy_corner(40), report, progress);
    const std::size_t target = mesh.triangles.size() / 4;
    const Mesh ours = decimated(mesh, {.max_faces = target, .piece_faces = 2000}, progress);
    const Mesh plain = decimated_openmesh(mesh, target, progress);
    CHECK(ours.triangles.size() <= target);
    CHECK(ours.triangles.size() + 4 >= plain.triangles.size());
    const auto added = sampled_distances(ours, mesh), lost = sampled_distances(mesh, ours);
    const auto plain_added = sampled_distances(plain, mesh), plain_lost = sampled_distances(mesh, plain);
    CHECK(mean(added) + mean(lost) < 0.8 * (mean(plain_added) + mean(plain_lost)));
    const auto p99 = [](const std::vector<double>& distances) { return distances[distances.size() * 99 / 100]; };
    CHECK(std::max(p99(added), p99(lost)) < 0.9 * std::max(p99(plain_added), p99(plain_lost)));
    CHECK(border_distance(ours, mesh) < border_distance(plain, mesh));
    CHECK(fresco::geometry::count_surface(ours).complex_edges == 0);
    CHECK(flipped_faces(ours, mesh) <= flipped_faces(plain, mesh));
}
