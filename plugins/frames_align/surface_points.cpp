#include "surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace fresco::align
{
namespace
{

constexpr double smallest_cell_m = 0.005;
constexpr int reach_px = 2;
constexpr double tolerance_share = 0.03;
constexpr double tolerance_m = 0.02;
constexpr double least_cosine = 0.2;

std::vector<std::uint32_t> one_per_cell(const Mesh& mesh, double cell_m)
{
    struct Place
    {
        std::array<int, 3> cell;
        std::uint32_t vertex;
    };
    std::vector<Place> places;
    places.reserve(mesh.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    {
        const Vec3d p = vec_cast<double>(mesh.positions[v]) * (1 / cell_m);
        places.push_back(
            {{static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)), static_cast<int>(std::floor(p.z))}, v});
    }
    std::ranges::sort(places,
                      [](const Place& a, const Place& b) { return a.cell != b.cell ? a.cell < b.cell : a.vertex < b.vertex; });
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < places.size(); ++i)
        if (i == 0 || places[i].cell != places[i - 1].cell)
            result.push_back(places[i].vertex);
    return result;
}

}  // namespace

std::vector<SurfacePoint> surface_points(const Mesh& mesh, std::size_t most)
{
    double cell_m = smallest_cell_m;
    auto chosen = one_per_cell(mesh, cell_m);
    while (chosen.size() > most)
        chosen = one_per_cell(mesh, cell_m *= std::numbers::sqrt2);
    const auto normals = vertex_normals(mesh);
    std::vector<SurfacePoint> points;
    points.reserve(chosen.size());
    for (const auto vertex : chosen)
        points.push_back({mesh.positions[vertex], normals[vertex]});
    return points;
}

std::vector<Sighting> sightings(const std::vector<SurfacePoint>& points, const Camera& camera, const RasterF& depth)
{
    const RigidTransform camera_from_world = camera.world_from_camera.inverse();
    const Intrinsics& k = camera.intrinsics;
    const auto is_open = [&](int column, int row, double z)
    {
        if (column < reach_px || row < reach_px || column + reach_px >= k.width || row + reach_px >= k.height)
            return false;
        for (int y = row - reach_px; y <= row + reach_px; ++y)
            for (int x = column - reach_px; x <= column + reach_px; ++x)
            {
                const auto seen = static_cast<double>(depth.at(x, y));
                if (!(std::abs(seen - z) <= tolerance_m + tolerance_share * z))
                    return false;
            }
        return true;
    };
    std::vector<Sighting> result;
    for (std::uint32_t i = 0; i < points.size(); ++i)
    {
        const Vec3d p = camera_from_world.point(vec_cast<double>(points[i].position));
        if (!(p.z > 0))
            continue;
        const double cosine = -dot(camera_from_world.direction(vec_cast<double>(points[i].normal)), p) / length(p);
        const double x = k.fx * p.x / p.z + k.cx;
        const double y = k.fy * p.y / p.z + k.cy;
        if (cosine < least_cosine || !(x >= 0 && y >= 0 && x < k.width && y < k.height))
            continue;
        if (is_open(static_cast<int>(x), static_cast<int>(y), p.z))
            result.push_back({i, static_cast<float>(cosine), vec_cast<float>(p)});
    }
    return result;
}

}  // namespace fresco::align
