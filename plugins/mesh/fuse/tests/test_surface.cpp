#include "catch.h"
#include "surface.h"

#include <fresco/geometry/topology.h>
#include <fresco/random.h>

#include <cmath>
#include <functional>
#include <numbers>

using namespace fresco;

namespace
{

constexpr double side_m = 0.05;

/// All blocks from (-n, -n, -n) to (n - 1, …), filled with distances; NaN: not measured.
fuse::Volume filled(int n, const std::function<double(Vec3d)>& distance)
{
    std::vector<fuse::BlockPlace> places;
    for (int x = -n; x < n; ++x)
        for (int y = -n; y < n; ++y)
            for (int z = -n; z < n; ++z)
                places.push_back({x, y, z});
    fuse::Volume volume(side_m, places);
    for (std::size_t i = 0; i < places.size(); ++i)
        for (int z = 0; z < 8; ++z)
            for (int y = 0; y < 8; ++y)
                for (int x = 0; x < 8; ++x)
                {
                    const double d = distance(volume.origin(i) + Vec3d{double(x), double(y), double(z)} * side_m);
                    if (!std::isnan(d))
                        volume.block(i)[fuse::voxel_index(x, y, z)] = {static_cast<float>(2 * d), 2};
                }
    return volume;
}

Mesh surface_of(const fuse::Volume& volume)
{
    const Progress progress;
    return fuse::Surface(volume, progress).mesh(progress);
}

/// Every edge has two faces that agree, every vertex is used, every face has an area.
void check_closed(const Mesh& mesh)
{
    const geometry::SurfaceCounts counts = geometry::count_surface(mesh);
    CHECK(counts.border_edges == 0);
    CHECK(counts.complex_edges == 0);
    CHECK(counts.vertices == mesh.positions.size());
    std::size_t flat = 0;
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        flat += length(geometry::area_vector(mesh, face)) > 0 ? 0 : 1;
    CHECK(flat == 0);
}

}  // namespace

TEST_CASE("a sphere across many blocks is closed, looks outward and has the right size")
{
    const Vec3d center{0.011, -0.023, 0.017};
    const Mesh mesh = surface_of(filled(3, [&](Vec3d p) { return length(p - center) - 0.9; }));
    check_closed(mesh);
    const geometry::SurfaceCounts counts = geometry::count_surface(mesh);
    CHECK(counts.components == 1);
    CHECK(counts.vertices + counts.faces == counts.edges + 2);
    CHECK(counts.area_m2 == Approx(4 * std::numbers::pi * 0.81).epsilon(0.005));
    double worst = 0;
    for (const Vec3f p : mesh.positions)
        worst = std::max(worst, std::abs(length(vec_cast<double>(p) - center) - 0.9));
    CHECK(worst < 0.0006);
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const Vec3d outward = vec_cast<double>(mesh.positions[mesh.triangles[face][0]]) - center;
        CHECK(dot(geometry::area_vector(mesh, face), outward) > 0);
    }
}

TEST_CASE("any distances make closed surfaces, in every case of a cube and across blocks")
{
    Random random(7);
    const double end = 2 * 8 * side_m;
    const auto is_last = [&](double at) { return at < -end + side_m / 2 || at > end - 1.5 * side_m; };
    const Mesh mesh =
        surface_of(filled(2, [&](Vec3d p) { return is_last(p.x) || is_last(p.y) || is_last(p.z) ? 1 : random.uniform() - 0.5; }));
    REQUIRE(mesh.triangles.size() > 50'000);
    check_closed(mesh);
}

TEST_CASE("nothing is made where something was not measured")
{
    const Mesh mesh = surface_of(filled(1, [](Vec3d p) { return p.x > 0.2 ? std::nan("") : p.z - 0.01; }));
    float farthest = 0;
    for (const Vec3f p : mesh.positions)
        farthest = std::max(farthest, p.x);
    CHECK(farthest == Approx(0.2));
    CHECK(geometry::count_surface(mesh).vertices == mesh.positions.size());
    CHECK(surface_of(filled(1, [](Vec3d) { return 1.0; })).triangles.empty());
}

TEST_CASE("small components are removed, whatever their number of faces")
{
    const auto two = [](Vec3d p) { return std::min(length(p - Vec3d{-0.2, 0, 0}) - 0.3, length(p - Vec3d{0.5, 0.1, 0}) - 0.12); };
    const Mesh both = surface_of(filled(2, two));
    REQUIRE(geometry::count_surface(both).components == 2);
    Mesh mesh = both;
    CHECK(fuse::remove_small_components(0.1, mesh) == 0);
    CHECK(mesh.positions == both.positions);
    CHECK(mesh.triangles == both.triangles);
    // 4 pi 0.12² = 0.18 m².
    CHECK(fuse::remove_small_components(0.2, mesh) == 1);
    check_closed(mesh);
    CHECK(geometry::count_surface(mesh).area_m2 == Approx(4 * std::numbers::pi * 0.09).epsilon(0.02));
    CHECK(fuse::remove_small_components(2, mesh) == 1);
    CHECK(mesh.positions.empty());
    CHECK(mesh.triangles.empty());
}
