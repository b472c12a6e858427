#include "projection.h"

#include <fresco/parallel.h>

namespace raster
{
namespace
{

constexpr std::size_t vertices_per_block = 16384;

}  // namespace

Frustum::Frustum(const fresco::Intrinsics& k)
{
    const auto box = [&](double margin)
    {
        return Box{(-margin * k.width - k.cx) / k.fx, ((1 + margin) * k.width - k.cx) / k.fx, (-margin * k.height - k.cy) / k.fy,
                   ((1 + margin) * k.height - k.cy) / k.fy};
    };
    picture = box(0);
    guard = box(1);
}

Projected Frustum::project(fresco::Vec3d point) const
{
    const auto beyond = [&](const Box& box)
    {
        return static_cast<std::uint8_t>((point.x < box.left * point.z ? left : 0) | (point.x > box.right * point.z ? right : 0) |
                                         (point.y < box.above * point.z ? above : 0) |
                                         (point.y > box.below * point.z ? below : 0));
    };
    Projected result;
    result.sides = beyond(picture);
    if (point.z < near_m)
    {
        result.sides |= behind;
        return result;
    }
    if (result.sides != 0 && beyond(guard) != 0)
    {
        result.sides |= far_aside;
        return result;
    }
    const double nearness = 1 / point.z;
    result.x = point.x * nearness;
    result.y = point.y * nearness;
    result.nearness = static_cast<float>(nearness);
    return result;
}

void project_all(const std::vector<fresco::Vec3f>& positions, const fresco::IntoCamera& into_camera, const Frustum& frustum,
                 const fresco::Progress& progress, std::vector<Projected>& projected)
{
    projected.resize(positions.size());
    fresco::parallel_for(positions.size(), vertices_per_block, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             for (std::size_t v = begin; v < end; ++v)
                                 projected[v] = frustum.project(into_camera.point(positions[v]));
                         });
}

}  // namespace raster
