#include "free_space.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace fresco::virtual_views
{
namespace
{

constexpr std::size_t feelers = 64;
constexpr double most_backs = 0.25;

/// 1 for the voxels that ways lead to, from center to center.
std::vector<std::uint8_t> reached(const raycast::Scene& scene, const VoxelGrid& grid, std::span<const Vec3d> eyes,
                                  const Progress& progress)
{
    std::vector<std::uint8_t> known(grid.count());
    std::vector<std::size_t> next;
    const auto go = [&](Vec3d from, const std::vector<std::size_t>& to)
    {
        std::vector<std::size_t> unknown;
        std::ranges::copy_if(to, std::back_inserter(unknown), [&](std::size_t voxel) { return known[voxel] == 0; });
        std::vector<Vec3d> toward;
        for (const std::size_t voxel : unknown)
            toward.push_back(grid.center(voxel) - from);
        const auto hits = hits_from(scene, from, toward);
        for (std::size_t i = 0; i < unknown.size(); ++i)
            if (!hits[i].found() || hits[i].distance > 1)
            {
                known[unknown[i]] = 1;
                next.push_back(unknown[i]);
            }
    };
    for (const Vec3d eye : eyes)
        go(eye, grid.around(eye));
    while (!next.empty())
    {
        if (next.size() % 1024 == 0)
            progress.check_canceled();
        const std::size_t voxel = next.back();
        next.pop_back();
        go(grid.center(voxel), grid.beside(voxel));
    }
    return known;
}

bool can_stand(const raycast::Scene& scene, Vec3d at, double clearance_m, std::span<const Vec3d> feel)
{
    const auto hits = hits_from(scene, at, feel);
    const auto met = std::ranges::count_if(hits, &raycast::Hit::found);
    const auto backs = std::ranges::count_if(hits, [](const raycast::Hit& hit) { return hit.found() && !hit.front; });
    const bool clear =
        std::ranges::all_of(hits, [&](const raycast::Hit& hit) { return !hit.found() || hit.distance >= clearance_m; });
    return clear && met > 0 && static_cast<double>(backs) <= most_backs * static_cast<double>(met);
}

}  // namespace

VoxelGrid::VoxelGrid(const Mesh& mesh, std::span<const Vec3d> eyes, const FreeSpaceRules& rules) : voxel_m_(rules.voxel_m)
{
    numerics::Bounds<double> box;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle)
            box.add(vec_cast<double>(mesh.positions[corner]));
    for (const Vec3d eye : eyes)
        box.add(eye);
    const Vec3d size = box.high - box.low;
    const std::string measured =
        fmt::format("the room measures {:.2f} x {:.2f} x {:.2f} m with its cameras", size.x, size.y, size.z);
    if (const double least = std::max(rules.voxel_m, 2 * rules.clearance_m); least > std::max({size.x, size.y, size.z}))
        throw Error(fmt::format(
            "{}, which leaves no place for a virtual camera: expected at least {:g} m; check that the mesh is in meters",
            measured, least));
    const auto voxels = [&](double along) { return std::max(1.0, std::ceil(along / voxel_m_)); };
    if (const double all = voxels(size.x) * voxels(size.y) * voxels(size.z); all > most_voxels)
        throw Error(fmt::format(
            "{}: {:.0f} voxels of {:g} m, where virtual cameras may stand; expected at most {:.0f}; check that the mesh "
            "is in meters",
            measured, all, voxel_m_, most_voxels));
    counts_ = {static_cast<std::size_t>(voxels(size.x)), static_cast<std::size_t>(voxels(size.y)),
               static_cast<std::size_t>(voxels(size.z))};
    const Vec3d spare{voxels(size.x) * voxel_m_ - size.x, voxels(size.y) * voxel_m_ - size.y, voxels(size.z) * voxel_m_ - size.z};
    least_ = box.low - spare * 0.5;
}

std::array<std::size_t, 3> VoxelGrid::place(std::size_t voxel) const
{
    return {voxel % counts_[0], voxel / counts_[0] % counts_[1], voxel / (counts_[0] * counts_[1])};
}

std::size_t VoxelGrid::number(const std::array<std::size_t, 3>& place) const
{
    return (place[2] * counts_[1] + place[1]) * counts_[0] + place[0];
}

Vec3d VoxelGrid::center(std::size_t voxel) const
{
    const auto at = place(voxel);
    const auto along = [&](std::size_t steps) { return (static_cast<double>(steps) + 0.5) * voxel_m_; };
    return least_ + Vec3d{along(at[0]), along(at[1]), along(at[2])};
}

std::vector<std::size_t> VoxelGrid::around(Vec3d point) const
{
    const Vec3d from = (point - least_) * (1 / voxel_m_);
    const std::array<double, 3> at{from.x, from.y, from.z};
    std::array<std::size_t, 3> first{};
    std::array<std::size_t, 3> end{};
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
        const double most = static_cast<double>(counts_[axis]) - 1;
        first[axis] = static_cast<std::size_t>(std::clamp(std::floor(at[axis]) - 1, 0.0, most));
        end[axis] = static_cast<std::size_t>(std::clamp(std::floor(at[axis]) + 1, 0.0, most)) + 1;
    }
    std::vector<std::size_t> result;
    for (std::size_t z = first[2]; z < end[2]; ++z)
        for (std::size_t y = first[1]; y < end[1]; ++y)
            for (std::size_t x = first[0]; x < end[0]; ++x)
                result.push_back(number({x, y, z}));
    return result;
}

std::vector<std::size_t> VoxelGrid::beside(std::size_t voxel) const
{
    std::vector<std::size_t> result;
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
        const auto at = place(voxel);
        auto before = at;
        auto after = at;
        --before[axis];
        ++after[axis];
        if (at[axis] > 0)
            result.push_back(number(before));
        if (after[axis] < counts_[axis])
            result.push_back(number(after));
    }
    return result;
}

std::vector<Vec3d> free_space(const raycast::Scene& scene, const VoxelGrid& grid, std::span<const Vec3d> eyes, double clearance_m,
                              const Progress& progress)
{
    auto free = reached(scene, grid, eyes, progress);
    const auto feel = numerics::spread_directions(feelers);
    parallel_items(free.size(), 1024, progress,
                   [&](std::size_t voxel)
                   {
                       if (free[voxel] != 0 && !can_stand(scene, grid.center(voxel), clearance_m, feel))
                           free[voxel] = 0;
                   });
    std::vector<Vec3d> centers;
    for (std::size_t voxel = 0; voxel < free.size(); ++voxel)
        if (free[voxel] != 0)
            centers.push_back(grid.center(voxel));
    return centers;
}

std::vector<raycast::Hit> hits_from(const raycast::Scene& scene, Vec3d origin, std::span<const Vec3d> directions)
{
    std::vector<raycast::Hit> hits(directions.size());
    for (std::size_t begin = 0; begin < hits.size(); begin += raycast::Scene::packet_size)
    {
        const std::size_t count = std::min<std::size_t>(raycast::Scene::packet_size, hits.size() - begin);
        scene.cast(origin, directions.subspan(begin, count), std::span(hits).subspan(begin, count));
    }
    return hits;
}

}  // namespace fresco::virtual_views
