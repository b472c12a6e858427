#include "house.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <fmt/format.h>
#include <limits>
#include <optional>

namespace matterport3d
{
namespace
{

namespace fs = std::filesystem;

/// "P name panorama region 0 x y z 0 0 0 0 0"; portals begin with P too, and have 15 words.
constexpr std::size_t panorama_words = 13;

}  // namespace

std::map<std::string, int> parse_regions(std::string_view text, std::string_view source)
{
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    fresco::recordings::LineReader lines(text, source);
    std::map<std::string, int> regions;
    std::optional<std::int64_t> promised;
    if (const auto head = lines.next(); !head || !head->starts_with("ASCII 1."))
        throw fresco::Error(std::string(source) + ": not a Matterport3D house file; expected 'ASCII 1.' at its start");
    while (const auto line = lines.next_record())
    {
        const auto words = fresco::recordings::words_of(*line);
        const auto place = lines.place();
        if (words[0].size() != 1 || std::string_view("HLRPSVICOE").find(words[0]) == std::string_view::npos)
            throw fresco::Error(place + ": '" + std::string(words[0]) + "'; expected one of H L R P S V I C O E");
        if (words[0] == "H")
        {
            if (words.size() < 5)
                throw fresco::Error(
                    fmt::format("{}: the header has {} words; the number of panoramas is missing", place, words.size()));
            promised = fresco::recordings::integer_of(words[4], 0, most, place);
        }
        else if (words[0] == "P" && words.size() == panorama_words)
        {
            const auto region = static_cast<int>(fresco::recordings::integer_of(words[3], -1, most, place));
            if (!regions.emplace(words[1], region).second)
                throw fresco::Error(place + ": panorama " + std::string(words[1]) + " appears twice");
        }
    }
    if (!promised || static_cast<std::size_t>(*promised) != regions.size())
        throw fresco::Error(fmt::format(
            "{}: the header declares {} panoramas, the file has {}: the file is truncated or was edited; copy it again", source,
            promised ? std::to_string(*promised) : "no", regions.size()));
    return regions;
}

fs::path camera_file(const fs::path& folder)
{
    const auto parameters = folder / "undistorted_camera_parameters";
    std::vector<fs::path> found;
    if (fs::is_directory(parameters))
        for (const auto& entry : fs::directory_iterator(parameters))
            if (entry.path().extension() == ".conf")
                found.push_back(entry.path());
    if (found.empty())
        throw fresco::MissingInput(parameters.string() +
                                   ": no camera file; expected <house>.conf, from the house's undistorted_camera_parameters.zip: "
                                   "unpack it, and set path to the folder that contains undistorted_camera_parameters");
    if (found.size() > 1)
        throw fresco::Error(fmt::format("{}: {} camera files, {} and {} among them; expected those of one house",
                                        parameters.string(), found.size(), found[0].filename().string(),
                                        found[1].filename().string()));
    return found.front();
}

}  // namespace matterport3d
