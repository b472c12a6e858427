#include "seen_colors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

using namespace fresco;

Raster8 seen_colors(const RasterF& depth, const Camera& depth_camera, const Raster8& picture, const Camera& color_camera)
{
    Raster8 result(depth.width, depth.height, 3);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const double meters = double{depth.at(x, y)};
            if (!(meters > 0))
                continue;
            const Vec3d point = depth_camera.world_from_camera.translation + depth_camera.ray(x + 0.5, y + 0.5) * meters;
            const Vec3d seen = color_camera.project(point);
            if (!(seen.z > 0))
                continue;
            const auto pixel = [](double at, int size) { return static_cast<int>(std::clamp(std::floor(at), 0.0, size - 1.0)); };
            const std::size_t from = picture.index(pixel(seen.x, picture.width), pixel(seen.y, picture.height));
            std::copy_n(&picture.values[from], 3, &result.values[result.index(x, y)]);
        }
    return result;
}
