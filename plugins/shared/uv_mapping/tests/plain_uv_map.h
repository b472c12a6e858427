#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>
#include <fresco/uv_mapping/shading.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstddef>
#include <vector>

/// \file A uv map by testing every face for every pixel: what each way of making uv maps must give, written without any of them
/// but for the rule of cracks.

namespace plain
{

using fresco::Vec3d;

using fresco::testing::RayHit;

inline void fill_pixel(const fresco::Mesh& mesh, const std::vector<fresco::Vec3f>& normals, const RayHit& hit, Vec3d ray,
                       fresco::UvMap& map, int x, int y)
{
    fresco::Vec2d uv;
    Vec3d normal;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto corner = mesh.texcoords[3 * hit.triangle + k];
        uv = uv + fresco::Vec2d{corner.x, corner.y} * hit.weights[k];
        normal += fresco::vec_cast<double>(normals[mesh.triangles[hit.triangle][k]]) * hit.weights[k];
    }
    map.uv.at(x, y, 0) = static_cast<float>(uv.x);
    map.uv.at(x, y, 1) = static_cast<float>(uv.y);
    map.depth.at(x, y) = static_cast<float>(hit.distance);
    map.cosine.at(x, y) = static_cast<float>(std::clamp(-dot(normalized(normal), normalized(ray)), 0.0, 1.0));
    map.valid.at(x, y) = 1;
}

/// One thread.
inline fresco::UvMap uv_map(const fresco::Mesh& mesh, const fresco::Camera& camera, int height_px)
{
    fresco::Camera scaled = camera;
    scaled.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(height_px), height_px);
    const int width = scaled.intrinsics.width;
    fresco::UvMap map{fresco::RasterF(width, height_px, 2), fresco::RasterF(width, height_px), fresco::RasterF(width, height_px),
                      fresco::Raster8(width, height_px)};
    const auto normals = fresco::vertex_normals(mesh);
    std::vector<RayHit> met;
    fresco::RasterF depth(width, height_px);
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            met.push_back(fresco::testing::cast(mesh, scaled.world_from_camera.translation, scaled.ray(x + 0.5, y + 0.5)));
            depth.at(x, y) = static_cast<float>(met.back().distance);
        }
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            const RayHit& here = met[static_cast<std::size_t>(y * width + x)];
            if (here.found() && here.front && here.distance >= 0.05 && !fresco::seen_through_crack(depth, x, y))
                fill_pixel(mesh, normals, here, scaled.ray(x + 0.5, y + 0.5), map, x, y);
        }
    return map;
}

}  // namespace plain
