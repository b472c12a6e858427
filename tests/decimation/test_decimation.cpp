#include "catch.h"
#include "decimate.h"
#include "decimate_openmesh.h"
#include "shapes.h"
#include "surface_figures.h"

#include <fresco/geometry/repair.h>

using fresco::Mesh;

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
    const auto distance = [&](const Mesh& result) { return bench::surface_distance(result, mesh, 20000, 1, 2).both(); };
    CHECK(distance(ours).mean < 0.8 * distance(plain).mean);
    CHECK(distance(ours).p99 < 0.9 * distance(plain).p99);
    const auto border = [&](const Mesh& result) { return bench::border_distance(result, mesh, 20000, 1, 2).both(); };
    CHECK(border(ours).mean < border(plain).mean);
    const auto ours_faults = bench::face_faults(ours, mesh, 2);
    CHECK(ours_faults.non_manifold_edges_created == 0);
    CHECK(ours_faults.degenerate == 0);
    CHECK(ours_faults.flipped <= bench::face_faults(plain, mesh, 2).flipped);
}
