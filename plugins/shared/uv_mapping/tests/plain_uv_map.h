#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cstddef>
#include <vector>

/// \file A uv map by testing every face for every pixel: what each way of making uv maps must give, written without any of them.

namespace plain
{

using fresco::Vec3d;

using fresco::testing::RayHit;

/// 5 cm and more behind each of eight neighbors.
inline bool through_crack(const std::vector<RayHit>& met, int width, int height, int x, int y)
{
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
        {
            if (dx == 0 && dy == 0)
                continue;
            if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height)
                return false;
            const auto at = [&](int i, int j)
            { return met[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)].distance; };
            if (!(at(x, y) > at(x + dx, y + dy) + 0.05))
                return false;
        }
    return true;
}

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
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
            met.push_back(fresco::testing::cast(mesh, scaled.world_from_camera.translation, scaled.ray(x + 0.5, y + 0.5)));
    std::size_t next = 0;
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            const RayHit& here = met[next++];
            if (here.found() && here.front && here.distance >= 0.05 && !through_crack(met, width, height_px, x, y))
                fill_pixel(mesh, normals, here, scaled.ray(x + 0.5, y + 0.5), map, x, y);
        }
    return map;
}

}  // namespace plain
