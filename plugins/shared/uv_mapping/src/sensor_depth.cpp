#include <fresco/uv_mapping/sensor_depth.h>

#include <cmath>

namespace fresco
{

RasterF sensor_depth(const UvMap& map, const Camera& color, const Camera& depth_camera, const RasterF& measured, float unmeasured)
{
    const int width = map.valid.width;
    const int height = map.valid.height;
    const Camera camera{color.intrinsics.scaled_to(width, height), color.world_from_camera};
    RasterF result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (map.valid.at(x, y) == 0)
                continue;
            const auto point =
                camera.world_from_camera.translation + camera.ray(x + 0.5, y + 0.5) * static_cast<double>(map.depth.at(x, y));
            const auto seen = depth_camera.project(point);
            const auto column = std::floor(seen.x);
            const auto row = std::floor(seen.y);
            const bool inside = seen.z > 0 && column >= 0 && row >= 0 && column < measured.width && row < measured.height;
            const float depth = inside ? measured.at(static_cast<int>(column), static_cast<int>(row)) : 0;
            result.at(x, y) = depth > 0 ? depth : unmeasured;
        }
    return result;
}

}  // namespace fresco
