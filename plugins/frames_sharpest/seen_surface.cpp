#include "seen_surface.h"

#include <algorithm>
#include <cmath>

namespace fresco::sharpest
{
namespace
{

/// How far depths of one surface may differ, which is sloped within a block and measured with errors.
double tolerance_m(double depth_m)
{
    return 0.05 + 0.05 * depth_m;
}

}  // namespace

SeenSurface::SeenSurface(const RasterF& depth, const Camera& depth_camera, const Camera& color, const Detail& blocks)
    : color_(color.intrinsics.scaled_to(blocks.width, blocks.height)), camera_from_world_(color.world_from_camera),
      columns_(blocks.columns), rows_(blocks.rows), points_(blocks.blocks.size())
{
    // About four samples a block.
    const int step = std::max(1, depth.width / std::max(1, 2 * columns_));
    for (int y = step / 2; y < depth.height; y += step)
        for (int x = step / 2; x < depth.width; x += step)
        {
            const double z = static_cast<double>(depth.at(x, y));
            if (!(z > 0))
                continue;
            const Vec3f world =
                vec_cast<float>(depth_camera.world_from_camera.translation + depth_camera.ray(x + 0.5, y + 0.5) * z);
            const Vec3d seen = camera_from_world_->point(world);
            const Vec2d pixel = pixel_of(seen);
            const auto block = block_at(pixel);
            if (!(seen.z > 0) || !block)
                continue;
            Point& point = points_[*block];
            if (point.depth_m == 0 || seen.z < static_cast<double>(point.depth_m))
                point = {world, {static_cast<float>(pixel.x), static_cast<float>(pixel.y)}, static_cast<float>(seen.z)};
        }
}

Vec2d SeenSurface::pixel_of(Vec3d in_camera) const
{
    return {color_.fx * in_camera.x / in_camera.z + color_.cx, color_.fy * in_camera.y / in_camera.z + color_.cy};
}

std::optional<std::size_t> SeenSurface::block_at(Vec2d pixel) const
{
    const double column = pixel.x / block_px;
    const double row = pixel.y / block_px;
    if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_))
        return std::nullopt;
    return static_cast<std::size_t>(static_cast<int>(row) * columns_ + static_cast<int>(column));
}

std::optional<SeenSurface::Place> SeenSurface::place_of(Vec3f world) const
{
    if (points_.empty())
        return std::nullopt;
    const Vec3d seen = camera_from_world_->point(world);
    if (!(seen.z > 0))
        return std::nullopt;
    const Vec2d pixel = pixel_of(seen);
    const auto block = block_at(pixel);
    if (!block)
        return std::nullopt;
    const auto there = static_cast<double>(points_[*block].depth_m);
    if (there == 0 || std::abs(there - seen.z) > tolerance_m(seen.z))
        return std::nullopt;
    return Place{*block, {static_cast<float>(pixel.x), static_cast<float>(pixel.y)}};
}

}  // namespace fresco::sharpest
