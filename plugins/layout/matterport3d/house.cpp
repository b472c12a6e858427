#include "house.h"

#include <fresco/error.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>

#include <fmt/format.h>
#include <limits>
#include <optional>

namespace matterport3d
{
namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

/// "P name panorama region 0 x y z 0 0 0 0 0"; portals begin with P too, and have 15 words.
constexpr std::size_t panorama_words = 13;

using Words = std::vector<std::string_view>;

void expect_words(const Words& words, std::size_t count, const std::string& place)
{
    if (words.size() != count)
        throw fresco::Error(
            fmt::format("{}: {} values after '{}'; expected {}", place, words.size() - 1, words.front(), count - 1));
}

std::string file_name(std::string_view word, const std::string& place)
{
    if (word.empty() || word.front() == '.' || word.find_first_of("/\\") != std::string_view::npos)
        throw fresco::Error(place + ": '" + std::string(word) + "' is not a plain file or folder name");
    return std::string(word);
}

std::vector<double> numbers(const Words& words, std::size_t first, const std::string& place)
{
    std::vector<double> values;
    for (std::size_t i = first; i < words.size(); ++i)
        values.push_back(number_of(words[i], place));
    return values;
}

}  // namespace

std::map<std::string, int> parse_regions(std::string_view text, std::string_view source)
{
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    LineReader lines(text, source);
    std::map<std::string, int> regions;
    std::optional<std::int64_t> promised;
    if (const auto head = lines.next(); !head || !head->starts_with("ASCII 1."))
        throw fresco::Error(std::string(source) + ": not a Matterport3D house file; expected 'ASCII 1.' at its start");
    while (const auto line = lines.next_record())
    {
        const auto words = words_of(*line);
        const auto place = lines.place();
        if (words[0].size() != 1 || std::string_view("HLRPSVICOE").find(words[0]) == std::string_view::npos)
            throw fresco::Error(place + ": '" + std::string(words[0]) + "'; expected one of H L R P S V I C O E");
        if (words[0] == "H")
        {
            if (words.size() < 5)
                throw fresco::Error(
                    fmt::format("{}: the header has {} words; the number of panoramas is missing", place, words.size()));
            promised = integer_of(words[4], 0, most, place);
        }
        else if (words[0] == "P" && words.size() == panorama_words)
        {
            const auto region = static_cast<int>(integer_of(words[3], -1, most, place));
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
            if (entry.path().extension() == ".conf" && !fresco::recordings::is_system_file(entry.path()))
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

HouseCameras parse_cameras(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    HouseCameras house;
    std::vector<double> intrinsics;
    std::optional<std::int64_t> promised;
    while (const auto line = lines.next_record())
    {
        const auto place = lines.place();
        const Words words = words_of(*line);
        const auto command = words.front();
        if (command == "dataset")
            expect_words(words, 2, place);
        else if (command == "n_images")
        {
            expect_words(words, 2, place);
            promised = integer_of(words[1], 1, 10'000'000, place);
        }
        else if (command == "depth_directory" || command == "color_directory")
        {
            expect_words(words, 2, place);
            (command == "depth_directory" ? house.depth_folder : house.color_folder) = file_name(words[1], place);
        }
        else if (command == "intrinsics_matrix")
        {
            expect_words(words, 10, place);
            intrinsics = numbers(words, 1, place);
        }
        else if (command == "scan")
        {
            expect_words(words, 19, place);
            if (intrinsics.empty())
                throw fresco::Error(place + ": a scan before any intrinsics_matrix");
            ListedView view;
            view.depth = file_name(words[1], place);
            view.color = file_name(words[2], place);
            view.panorama = view.color.substr(0, view.color.find('_'));
            view.intrinsics = intrinsics;
            view.world_from_camera = opencv_pose(numbers(words, 3, place), place);
            view.source = place;
            house.views.push_back(std::move(view));
        }
        else
            throw fresco::Error(place + ": '" + std::string(command) +
                                "'; expected dataset, n_images, depth_directory, color_directory, intrinsics_matrix or scan");
    }
    if (!promised)
        throw fresco::Error(std::string(source) + ": n_images is missing; expected the camera file of a Matterport3D house");
    if (static_cast<std::size_t>(*promised) != house.views.size())
        throw fresco::Error(
            fmt::format("{}: n_images declares {} views, the file has {}: the file is truncated or was edited; copy it again",
                        source, *promised, house.views.size()));
    return house;
}

fresco::Intrinsics camera_of(const ListedView& view, int width, int height)
{
    auto k = intrinsics_from_matrix(view.intrinsics, PixelCenter::integer, width, height, view.source);
    k.cy = height - k.cy;
    return k;
}

}  // namespace matterport3d
