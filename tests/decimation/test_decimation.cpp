#include "catch.h"
#include "decimate.h"
#include "decimate_openmesh.h"
#include "shapes.h"
#include "surface_samples.h"

#include <fresco/geometry/repair.h>

using fresco::Mesh;

namespace
{

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

TEST_CASE("optimal points are nearer to the surface than points of the mesh")
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
    CHECK(fresco::geometry::count_surface(ours).complex_edges == 0);
    CHECK(flipped_faces(ours, mesh) <= flipped_faces(plain, mesh));
}
