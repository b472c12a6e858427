#include "model.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <fmt/format.h>
#include <limits>
#include <optional>

namespace colmap
{
namespace
{

using namespace fresco::recordings;

constexpr std::int64_t most_ids = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t pose_words = 9;  // Before the name: id, quaternion, translation, camera.

bool is_blank(std::string_view line)
{
    return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

/// The count in a comment "# Number of images: 3, …".
std::optional<std::int64_t> announced(std::string_view line, std::string_view what)
{
    const std::string begin = "# Number of " + std::string(what) + ": ";
    if (!line.starts_with(begin))
        return std::nullopt;
    const auto rest = line.substr(begin.size());
    return integer_of(rest.substr(0, rest.find_first_of(", \r")), 0, most_ids, "the comment " + begin);
}

void check_count(std::optional<std::int64_t> expected, std::size_t count, std::string_view source, std::string_view what)
{
    if (expected && static_cast<std::uint64_t>(*expected) != count)
        throw fresco::Error(fmt::format(
            "{}: {} {}; its header declares {}; the file is truncated or was edited: copy it again or correct the header", source,
            count, what, *expected));
}

/// The rest of a line behind its first `count` words, without blanks around it: names may have blanks inside.
std::string_view behind_words(std::string_view line, const std::vector<std::string_view>& words, std::size_t count)
{
    const auto begin = static_cast<std::size_t>(words[count].data() - line.data());
    const auto end = line.find_last_not_of(" \t\r");
    return line.substr(begin, end + 1 - begin);
}

ModelImage image_of(std::string_view line, const std::string& place)
{
    const auto words = words_of(line);
    if (words.size() <= pose_words)
        throw fresco::Error(
            fmt::format("{}: {} words; expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", place, words.size()));
    std::vector<double> numbers;
    for (std::size_t i = 1; i < 8; ++i)
        numbers.push_back(number_of(words[i], place));
    integer_of(words[0], 0, most_ids, place);
    ModelImage image;
    image.world_from_camera =
        quaternion_transform(numbers[0], numbers[1], numbers[2], numbers[3], {numbers[4], numbers[5], numbers[6]}, place)
            .inverse();
    image.camera = integer_of(words[8], 0, most_ids, place);
    image.name = behind_words(line, words, pose_words);
    image.source = place;
    return image;
}

}  // namespace

Cameras parse_cameras_text(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    Cameras cameras;
    std::optional<std::int64_t> expected;
    while (const auto line = lines.next())
    {
        if (const auto count = announced(*line, "cameras"))
            expected = count;
        if (is_blank(*line) || line->starts_with('#'))
            continue;
        const auto place = lines.place();
        const auto words = words_of(*line);
        if (words.size() < 4)
            throw fresco::Error(fmt::format("{}: {} words; expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS…", place, words.size()));
        const auto id = integer_of(words[0], 0, most_ids, place);
        const auto& model = camera_model(words[1], place);
        const auto width = integer_of(words[2], 1, most_ids, place), height = integer_of(words[3], 1, most_ids, place);
        std::vector<double> parameters;
        for (std::size_t i = 4; i < words.size(); ++i)
            parameters.push_back(number_of(words[i], place));
        auto camera =
            model_camera(model, static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height), parameters, place);
        if (!cameras.emplace(id, std::move(camera)).second)
            throw fresco::Error(fmt::format("{}: the camera {} appears twice", place, id));
    }
    check_count(expected, cameras.size(), source, "cameras");
    return cameras;
}

std::vector<ModelImage> parse_images_text(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    std::vector<ModelImage> images;
    std::optional<std::int64_t> expected;
    while (const auto line = lines.next())
    {
        if (const auto count = announced(*line, "images"))
            expected = count;
        if (is_blank(*line) || line->starts_with('#'))
            continue;
        images.push_back(image_of(*line, lines.place()));
        // The line of its points, which may be empty.
        const auto points = lines.next();
        if (!points)
            throw fresco::Error(
                lines.place() +
                ": the line with the image's points is missing (it may be empty): the file is truncated; copy it again");
        if (words_of(*points).size() % 3 != 0)
            throw fresco::Error(lines.place() + ": expected an image's points, X Y POINT3D_ID each, or an empty line");
    }
    check_count(expected, images.size(), source, "images");
    return images;
}

}  // namespace colmap
