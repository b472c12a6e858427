#include "uv_map_caster.h"

#include <fresco/parallel.h>
#include <fresco/raycast/surface.h>

#include <algorithm>
#include <cstddef>

using fresco::raycast::Hit;
using fresco::raycast::Sight;

namespace
{
constexpr int rows_per_block = 16;
}

PixelCounts& PixelCounts::operator+=(const PixelCounts& other)
{
    valid += other.valid;
    back_face += other.back_face;
    too_near += other.too_near;
    nothing += other.nothing;
    return *this;
}

UvMapCaster::UvMapCaster(const fresco::Mesh& mesh) : scene_(mesh), vertex_normals_(fresco::vertex_normals(mesh)) {}

PixelCounts UvMapCaster::cast_rows(const fresco::Camera& camera, int first_row, int end_row, fresco::UvMap& map) const
{
    const fresco::Mesh& mesh = scene_.mesh();
    const int width = camera.intrinsics.width;
    std::vector<Hit> hits(static_cast<std::size_t>(end_row - first_row) * static_cast<std::size_t>(width));
    scene_.cast_rows(camera, first_row, end_row, hits);

    PixelCounts counts;
    std::size_t next = 0;
    for (int y = first_row; y < end_row; ++y)
        for (int x = 0; x < width; ++x)
        {
            const Hit& hit = hits[next++];
            switch (fresco::raycast::sight(hit))
            {
            case Sight::nothing:
                ++counts.nothing;
                continue;
            case Sight::back_face:
                ++counts.back_face;
                continue;
            case Sight::too_near:
                ++counts.too_near;
                continue;
            case Sight::surface:
                break;
            }
            ++counts.valid;
            const fresco::Vec2d uv = fresco::raycast::texcoord(mesh, hit);
            const fresco::Vec3d to_camera = -fresco::normalized(camera.ray(x + 0.5, y + 0.5));
            const double cosine = dot(fresco::raycast::normal(mesh, vertex_normals_, hit), to_camera);
            map.uv.at(x, y, 0) = static_cast<float>(uv.x);
            map.uv.at(x, y, 1) = static_cast<float>(uv.y);
            map.depth.at(x, y) = static_cast<float>(hit.distance);
            map.cosine.at(x, y) = static_cast<float>(std::clamp(cosine, 0.0, 1.0));
            map.valid.at(x, y) = 1;
        }
    return counts;
}

fresco::UvMap UvMapCaster::cast(const fresco::Camera& camera, int height_px, const fresco::Progress& progress,
                                PixelCounts& counts) const
{
    fresco::Camera scaled = camera;
    scaled.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(height_px), height_px);
    const int width = scaled.intrinsics.width;

    fresco::UvMap map;
    map.uv = fresco::RasterF(width, height_px, 2);
    map.depth = fresco::RasterF(width, height_px);
    map.cosine = fresco::RasterF(width, height_px);
    map.valid = fresco::Raster8(width, height_px);

    const auto rows = static_cast<std::size_t>(height_px);
    std::vector<PixelCounts> per_block((rows + rows_per_block - 1) / rows_per_block);
    fresco::parallel_for(rows, rows_per_block, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_cancelled();
                             per_block[begin / rows_per_block] =
                                 cast_rows(scaled, static_cast<int>(begin), static_cast<int>(end), map);
                         });
    counts = {};
    for (const PixelCounts& block : per_block)
        counts += block;
    return map;
}
