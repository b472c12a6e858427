#include "fusion.h"

#include <open3d/Open3DConfig.h>
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>
#include <open3d/pipelines/integration/UniformTSDFVolume.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_set>

using namespace fresco;
namespace tsdf = open3d::pipelines::integration;

namespace
{
constexpr int block_voxels = 16;
/// Every so many pixels a ray opens the blocks around its end; small pictures are looked at whole.
constexpr int stride = 4;
constexpr int small_width = 320;

Eigen::Matrix4d camera_from_world(const RigidTransform& world_from_camera)
{
    const RigidTransform inverse = world_from_camera.inverse();
    Eigen::Matrix4d result = Eigen::Matrix4d::Identity();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            result(row, column) = inverse.rotation(row, column);
    result.block<3, 1>(0, 3) << inverse.translation.x, inverse.translation.y, inverse.translation.z;
    return result;
}

std::size_t bytes_of_blocks(std::size_t count)
{
    return count * block_voxels * block_voxels * block_voxels * sizeof(open3d::geometry::TSDFVoxel);
}

int stride_for(const RasterF& depth)
{
    return depth.width < small_width ? 1 : stride;
}

/// Open3D counts pixels' centers from (0, 0), fresco from (0.5, 0.5).
open3d::camera::PinholeCameraIntrinsic intrinsics_of(const Intrinsics& k)
{
    return {k.width, k.height, k.fx, k.fy, k.cx - 0.5, k.cy - 0.5};
}

template <class T>
void fill(open3d::geometry::Image& image, const Raster<T>& raster)
{
    image.Prepare(raster.width, raster.height, raster.channels, sizeof(T));
    std::memcpy(image.data_.data(), raster.values.data(), raster.values.size() * sizeof(T));
}

std::uint8_t step_of(double share)
{
    return static_cast<std::uint8_t>(std::lround(std::clamp(share, 0.0, 1.0) * 255));
}
}  // namespace

struct Fusion::Volume
{
    tsdf::ScalableTSDFVolume blocks;
};

Fusion::Fusion(const FusionOptions& options)
    : volume_(new Volume{
          tsdf::ScalableTSDFVolume(options.voxel_m, options.truncation_m, tsdf::TSDFVolumeColorType::RGB8, block_voxels, stride)})
{
}

Fusion::~Fusion() = default;

void Fusion::add(const RasterF& depth, const Raster8& colors, const Camera& camera)
{
    volume_->blocks.depth_sampling_stride_ = stride_for(depth);
    open3d::geometry::RGBDImage picture;
    fill(picture.depth_, depth);
    fill(picture.color_, colors);
    volume_->blocks.Integrate(picture, intrinsics_of(camera.intrinsics), camera_from_world(camera.world_from_camera));
}

std::size_t Fusion::bytes() const
{
    return bytes_of_blocks(volume_->blocks.volume_units_.size());
}

bool Fusion::fits(const RasterF& depth, const Camera& camera, std::size_t limit_bytes) const
{
    const auto& blocks = volume_->blocks;
    const auto block = [&](double at) { return static_cast<int>(std::floor(at / blocks.volume_unit_length_)); };
    std::unordered_set<Eigen::Vector3i, open3d::utility::hash_eigen<Eigen::Vector3i>> opened;
    const int step = stride_for(depth);
    // As Integrate does it: the blocks within the truncation of the end of every so many rays.
    for (int v = 0; v < depth.height; v += step)
        for (int u = 0; u < depth.width; u += step)
        {
            const double meters = double{depth.at(u, v)};
            if (!(meters > 0))
                continue;
            const Vec3d end = camera.world_from_camera.translation + camera.ray(u + 0.5, v + 0.5) * meters;
            const double reach = blocks.sdf_trunc_;
            for (int x = block(end.x - reach); x <= block(end.x + reach); ++x)
                for (int y = block(end.y - reach); y <= block(end.y + reach); ++y)
                    for (int z = block(end.z - reach); z <= block(end.z + reach); ++z)
                    {
                        const Eigen::Vector3i index(x, y, z);
                        if (!blocks.volume_units_.contains(index) && opened.insert(index).second &&
                            bytes_of_blocks(blocks.volume_units_.size() + opened.size()) > limit_bytes)
                            return false;
                    }
        }
    return true;
}

Mesh Fusion::mesh() const
{
    const auto surface = volume_->blocks.ExtractTriangleMesh();
    Mesh result;
    for (const Eigen::Vector3d& p : surface->vertices_)
        result.positions.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    for (const Eigen::Vector3d& c : surface->vertex_colors_)
        result.colors.push_back({step_of(c.x()), step_of(c.y()), step_of(c.z())});
    for (const Eigen::Vector3i& t : surface->triangles_)
        if (t.x() != t.y() && t.y() != t.z() && t.z() != t.x())
            result.triangles.push_back(
                {static_cast<std::uint32_t>(t.x()), static_cast<std::uint32_t>(t.y()), static_cast<std::uint32_t>(t.z())});
    return result;
}

const char* open3d_version()
{
    return OPEN3D_VERSION;
}
