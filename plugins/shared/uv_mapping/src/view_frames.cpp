#include <fresco/error.h>
#include <fresco/uv_mapping/view_frames.h>

#include <cmath>
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
            if (seen.z > 0 && column >= 0 && row >= 0 && column < measured.width && row < measured.height)
                result.at(x, y) = measured.at(static_cast<int>(column), static_cast<int>(row));
        }
    return result;
}

}  // namespace fresco
