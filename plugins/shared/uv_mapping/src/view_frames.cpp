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

}  // namespace fresco
