#include <fresco/error.h>
#include <fresco/uv_mapping/view_frames.h>

#include <map>
#include <string>
#include <utility>

namespace fresco
{

std::vector<std::size_t> frames_of_views(const UvMaps& maps, const Frames& frames)
{
    std::map<std::pair<std::string, std::string>, std::size_t> known;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
        known.emplace(std::pair(frames.frames[i].sequence, frames.frames[i].name), i);
    std::vector<std::size_t> result;
    for (const auto& view : maps.views)
    {
        const auto found = known.find({view.sequence, view.frame});
        if (found == known.end())
            throw Error("the uv maps show frame " + view.sequence + "/" + view.frame +
                        ", which is missing on port 'frames'; wire the frames that the uv maps were made from");
        result.push_back(found->second);
    }
    return result;
}

RasterF sensor_depth(const UvMap& map, const Camera& color, const Camera& depth_camera, const RasterF& measured)
{
    const int width = map.valid.width;
    const int height = map.valid.height;
    const Intrinsics own = color.intrinsics.scaled_to(width, height);
    const Intrinsics& other = depth_camera.intrinsics;
    const RigidTransform other_from_own = depth_camera.world_from_camera.inverse() * color.world_from_camera;
    RasterF result(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (map.valid.at(x, y) == 0)
                continue;
            const auto depth = static_cast<double>(map.depth.at(x, y));
            const Vec3d seen =
                other_from_own.point({(x + 0.5 - own.cx) / own.fx * depth, (y + 0.5 - own.cy) / own.fy * depth, depth});
            const double column = other.fx * seen.x / seen.z + other.cx;
            const double row = other.fy * seen.y / seen.z + other.cy;
            if (seen.z > 0 && column >= 0 && row >= 0 && column < measured.width && row < measured.height)
                result.at(x, y) = measured.at(static_cast<int>(column), static_cast<int>(row));
        }
    return result;
}

}  // namespace fresco
