#include "integration.h"

#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

using namespace fresco;

namespace fuse
{
namespace
{

constexpr int tile_px = 16;
constexpr float nearest_m = 1e-3F;

/// A view, prepared for many blocks.
class Integrator
{
  public:
    Integrator(const DepthView& view, double voxel_m, double truncation_m)
        : view_(view), camera_from_world_(view.camera.world_from_camera.inverse()),
          fx_(static_cast<float>(view.camera.intrinsics.fx)), fy_(static_cast<float>(view.camera.intrinsics.fy)),
          cx_(static_cast<float>(view.camera.intrinsics.cx)), cy_(static_cast<float>(view.camera.intrinsics.cy)),
          voxel_(static_cast<float>(voxel_m)), truncation_(static_cast<float>(truncation_m)),
          farthest_((view.planes.width + tile_px - 1) / tile_px, (view.planes.height + tile_px - 1) / tile_px)
    {
        const auto step = [&](Vec3d axis) { return vec_cast<float>(camera_from_world_.direction(axis * voxel_m)); };
        step_x_ = step({1, 0, 0});
        step_y_ = step({0, 1, 0});
        step_z_ = step({0, 0, 1});
        find_farthest();
    }

    void add(Vec3d origin, Block& block) const
    {
        const Vec3f first = vec_cast<float>(camera_from_world_.point(origin));
        if (!may_see(first))
            return;
        for (int z = 0; z < block_side; ++z)
            for (int y = 0; y < block_side; ++y)
            {
                const Vec3f row = first + step_y_ * static_cast<float>(y) + step_z_ * static_cast<float>(z);
                for (int x = 0; x < block_side; ++x)
                    add(row + step_x_ * static_cast<float>(x), block[voxel_index(x, y, z)]);
            }
    }

  private:
    void add(Vec3f point, Voxel& voxel) const
    {
        if (!(point.z > nearest_m))
            return;
        const float scale = 1 / point.z;
        const float u = fx_ * point.x * scale + cx_;
        const float v = fy_ * point.y * scale + cy_;
        if (!(u >= 0 && v >= 0 && u < static_cast<float>(view_.planes.width) && v < static_cast<float>(view_.planes.height)))
            return;
        const PixelPlane& plane = view_.planes.at(static_cast<int>(u), static_cast<int>(v));
        const float distance = plane.distance(point);
        if (!(plane.weight > 0) || !(distance > -truncation_))
            return;
        const float share = distance >= -voxel_ ? 1.0F : (truncation_ + distance) / (truncation_ - voxel_);
        const float weight = plane.weight * share;
        voxel.distance_sum += weight * std::min(distance, truncation_);
        voxel.weight += weight;
    }

    /// For each tile the largest depth at which one of its pixels changes a voxel.
    void find_farthest()
    {
        for (int y = 0; y < view_.planes.height; ++y)
            for (int x = 0; x < view_.planes.width; ++x)
            {
                const PixelPlane& plane = view_.planes.at(x, y);
                if (!(plane.weight > 0))
                    continue;
                const Vec3f ray{(static_cast<float>(x) + 0.5F - cx_) / fx_, (static_cast<float>(y) + 0.5F - cy_) / fy_, 1};
                // The least of the pixel's rays.
                const float toward =
                    -dot(plane.normal, ray) - 0.5F * (std::abs(plane.normal.x) / fx_ + std::abs(plane.normal.y) / fy_);
                const float depth = toward > 0 ? (plane.offset + truncation_) / toward : std::numeric_limits<float>::infinity();
                float& farthest = farthest_.at(x / tile_px, y / tile_px);
                farthest = std::max(farthest, depth);
            }
    }

    /// Whether the view may change a voxel of the block whose first voxel is at `first` in the camera's frame.
    bool may_see(Vec3f first) const
    {
        constexpr float infinite = std::numeric_limits<float>::infinity();
        float low_u = infinite, low_v = infinite, high_u = -infinite, high_v = -infinite, low_z = infinite;
        bool some_behind = false;
        float high_z = -infinite;
        for (int corner = 0; corner < 8; ++corner)
        {
            const auto shift = [&](int bit) { return (corner >> bit & 1) != 0 ? static_cast<float>(block_side - 1) : 0.0F; };
            const Vec3f p = first + step_x_ * shift(0) + step_y_ * shift(1) + step_z_ * shift(2);
            low_z = std::min(low_z, p.z);
            high_z = std::max(high_z, p.z);
            some_behind = some_behind || !(p.z > nearest_m);
            const float scale = 1 / p.z;
            const float u = fx_ * p.x * scale + cx_;
            const float v = fy_ * p.y * scale + cy_;
            low_u = std::min(low_u, u);
            high_u = std::max(high_u, u);
            low_v = std::min(low_v, v);
            high_v = std::max(high_v, v);
        }
        if (some_behind)
            return high_z > nearest_m;
        // A pixel more, for what rounding does.
        const auto tile = [](float at, int count)
        { return static_cast<int>(std::clamp(std::floor(at / tile_px), 0.0F, static_cast<float>(count - 1))); };
        if (high_u < -1 || high_v < -1 || low_u > static_cast<float>(view_.planes.width) + 1 ||
            low_v > static_cast<float>(view_.planes.height) + 1)
            return false;
        for (int y = tile(low_v - 1, farthest_.height); y <= tile(high_v + 1, farthest_.height); ++y)
            for (int x = tile(low_u - 1, farthest_.width); x <= tile(high_u + 1, farthest_.width); ++x)
                if (low_z * 0.9999F < farthest_.at(x, y))
                    return true;
        return false;
    }

    const DepthView& view_;
    RigidTransform camera_from_world_;
    float fx_, fy_, cx_, cy_;
    float voxel_, truncation_;
    Vec3f step_x_, step_y_, step_z_;
    RasterF farthest_;
};

}  // namespace

void integrate(std::span<const DepthView> views, double truncation_m, const Progress& progress, Volume& volume)
{
    std::vector<Integrator> integrators;
    for (const DepthView& view : views)
        integrators.emplace_back(view, volume.voxel_m(), truncation_m);
    parallel_for(volume.places().size(), 64, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t i = begin; i < end; ++i)
                         for (const Integrator& integrator : integrators)
                             integrator.add(volume.origin(i), volume.block(i));
                 });
}

}  // namespace fuse
