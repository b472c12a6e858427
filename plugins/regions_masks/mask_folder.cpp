#include "mask_folder.h"

#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <map>
#include <set>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

constexpr std::size_t ambiguous = static_cast<std::size_t>(-1);

std::map<std::string, std::size_t> frames_by_name(const std::vector<Frame>& frames)
{
    std::map<std::string, std::size_t> result;
    for (std::size_t i = 0; i < frames.size(); ++i)
    {
        const auto [known, fresh] = result.emplace(frames[i].name, i);
        if (!fresh)
            known->second = ambiguous;
    }
    for (std::size_t i = 0; i < frames.size(); ++i)
        result.insert_or_assign(frames[i].sequence + "_" + frames[i].name, i);
    return result;
}

std::set<fs::path> entries(const fs::path& folder)
{
    std::set<fs::path> result;
    for (const auto& entry : fs::directory_iterator(folder))
        if (!entry.path().filename().string().starts_with('.'))
            result.insert(entry.path());
    return result;
}

bool is_picture(const fs::path& file)
{
    return file.extension() == ".png" || file.extension() == ".jpg";
}

}  // namespace

std::vector<MaskedRegion> find_masks(const fs::path& folder, const std::vector<Frame>& frames)
{
    const auto by_name = frames_by_name(frames);
    std::vector<MaskedRegion> result;
    for (const fs::path& part : entries(folder))
    {
        if (!fs::is_directory(part))
            continue;
        MaskedRegion region{part.filename().string(), {}};
        std::map<std::size_t, fs::path> of_frame;
        for (const fs::path& file : entries(part))
        {
            if (!is_picture(file))
                continue;
            const auto frame = by_name.find(file.stem().string());
            if (frame == by_name.end())
            {
                std::vector<std::string> names;
                for (const auto& [name, index] : by_name)
                    names.push_back(name);
                throw Error(file.string() + ": there is no frame '" + file.stem().string() + "'" +
                            suggestion(file.stem().string(), names, 4) + "; name masks after the frames on port 'frames'");
            }
            if (frame->second == ambiguous)
                throw Error(file.string() + ": several sequences have a frame '" + frame->first +
                            "': name the mask <sequence>_<frame>");
            const auto [other, fresh] = of_frame.emplace(frame->second, file);
            if (!fresh)
                throw Error(file.string() + " and " + other->second.string() + " are masks of the same frame: remove one");
        }
        for (auto& [frame, file] : of_frame)
            region.masks.push_back({frame, file});
        if (!region.masks.empty())
            result.push_back(std::move(region));
    }
    if (result.empty())
        throw MissingInput(folder.string() + ": no masks; expected pictures in a folder for each region, such as " +
                           (folder / "floor" / "frame-000000.png").string());
    return result;
}
