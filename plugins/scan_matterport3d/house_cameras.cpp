#include "house_cameras.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>
#include <fresco/recordings/recorded_view.h>

#include <fmt/format.h>
#include <optional>

namespace matterport3d
{
namespace
{

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
        values.push_back(fresco::recordings::number_of(words[i], place));
    return values;
}

}  // namespace

HouseCameras parse_cameras(std::string_view text, std::string_view source)
{
    fresco::recordings::LineReader lines(text, source);
    HouseCameras house;
    std::vector<double> intrinsics;
    std::optional<std::int64_t> promised;
    while (const auto line = lines.next_record())
    {
        const auto place = lines.place();
        const Words words = fresco::recordings::words_of(*line);
        const auto command = words.front();
        if (command == "dataset")
            expect_words(words, 2, place);
        else if (command == "n_images")
        {
            expect_words(words, 2, place);
            promised = fresco::recordings::integer_of(words[1], 1, 10'000'000, place);
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
            view.world_from_camera = fresco::recordings::opencv_pose(numbers(words, 3, place), place);
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

fresco::Intrinsics camera_of(const ListedView& view, int width, int height, ImageOrigin origin)
{
    auto k = fresco::recordings::intrinsics_from_matrix(view.intrinsics, fresco::recordings::PixelCenter::integer, width, height,
                                                        view.source);
    if (origin == ImageOrigin::bottom_left)
        k.cy = height - k.cy;
    return k;
}

}  // namespace matterport3d
