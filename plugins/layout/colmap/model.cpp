#include "model.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <ranges>

namespace colmap
{
namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

constexpr std::uint64_t most_pixels = 65536;

const std::vector<CameraModel>& read_models()
{
    static const std::vector<CameraModel> models{
        {0, "SIMPLE_PINHOLE", {"f", "cx", "cy"}},
        {1, "PINHOLE", {"fx", "fy", "cx", "cy"}},
        {2, "SIMPLE_RADIAL", {"f", "cx", "cy", "k1"}},
        {3, "RADIAL", {"f", "cx", "cy", "k1", "k2"}},
        {4, "OPENCV", {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"}},
        {5, "OPENCV_FISHEYE", {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"}, true},
        {6, "FULL_OPENCV", {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
        {8, "SIMPLE_RADIAL_FISHEYE", {"f", "cx", "cy", "k1"}, true},
        {9, "RADIAL_FISHEYE", {"f", "cx", "cy", "k1", "k2"}, true},
        {14, "SIMPLE_FISHEYE", {"f", "cx", "cy"}, true},
        {15, "FISHEYE", {"fx", "fy", "cx", "cy"}, true},
        {17, "EQUIRECTANGULAR", {"w", "h"}},
        // The name in forks of COLMAP and PoseLib.
        {17, "SPHERICAL", {"w", "h"}},
    };
    return models;
}

/// COLMAP's other models, by their ids.
constexpr std::array<std::pair<std::int32_t, std::string_view>, 6> other_models{{{7, "FOV"},
                                                                                 {10, "THIN_PRISM_FISHEYE"},
                                                                                 {11, "RAD_TAN_THIN_PRISM_FISHEYE"},
                                                                                 {12, "SIMPLE_DIVISION"},
                                                                                 {13, "DIVISION"},
                                                                                 {16, "EUCM"}}};

[[noreturn]] void refuse(const std::string& model, const std::string& place)
{
    throw fresco::Error(
        fmt::format("{}: camera model {} is not supported; expected {}: undistort with \"colmap image_undistorter\" first", place,
                    model, fmt::join(read_models() | std::views::transform(&CameraModel::name), ", ")));
}

constexpr std::uint64_t point_bytes = 24;  // Two doubles and a number of 64 bits.

constexpr std::int64_t most_ids = std::numeric_limits<std::int64_t>::max();
constexpr std::size_t pose_words = 9;  // Before the name: id, quaternion, translation, camera.

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

/// Pose of a camera from QW QX QY QZ TX TY TZ.
fresco::RigidTransform pose_of(const std::array<double, 7>& n, const std::string& place)
{
    return quaternion_transform(n[0], n[1], n[2], n[3], {n[4], n[5], n[6]}, place).inverse();
}

ModelImage image_of(std::string_view line, const std::string& place)
{
    const auto words = words_of(line);
    if (words.size() <= pose_words)
        throw fresco::Error(
            fmt::format("{}: {} words; expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME", place, words.size()));
    std::array<double, 7> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = number_of(words[i + 1], place);
    integer_of(words[0], 0, most_ids, place);
    ModelImage image;
    image.world_from_camera = pose_of(numbers, place);
    image.camera = integer_of(words[8], 0, most_ids, place);
    image.name = behind_words(line, words, pose_words);
    image.source = place;
    return image;
}

}  // namespace

const CameraModel& camera_model(std::string_view name, const std::string& place)
{
    const auto found = std::ranges::find(read_models(), name, &CameraModel::name);
    if (found == read_models().end())
        refuse("\"" + std::string(name.substr(0, 40)) + "\"", place);
    return *found;
}

const CameraModel& camera_model(std::int32_t id, const std::string& place)
{
    const auto found = std::ranges::find(read_models(), id, &CameraModel::id);
    if (found != read_models().end())
        return *found;
    for (const auto& [other, name] : other_models)
        if (other == id)
            refuse(std::string(name), place);
    refuse("of number " + std::to_string(id), place);
}

ModelCamera model_camera(const CameraModel& model, std::uint64_t width, std::uint64_t height,
                         const std::vector<double>& parameters, std::string place)
{
    if (width < 1 || height < 1 || width > most_pixels || height > most_pixels)
        throw fresco::Error(fmt::format("{}: a picture of {}x{} pixels; expected 1 to 65536", place, width, height));
    if (parameters.size() != model.parameters.size())
        throw fresco::Error(
            fmt::format("{}: {} parameters; {} has {}", place, parameters.size(), model.name, model.parameters.size()));
    ModelCamera camera;
    camera.lens.is_fisheye = model.is_fisheye;
    camera.intrinsics.width = static_cast<int>(width);
    camera.intrinsics.height = static_cast<int>(height);
    auto& k = camera.intrinsics;
    auto& lens = camera.lens;
    constexpr std::array<std::string_view, 12> names{"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"};
    const std::array<double*, 12> places{&k.fx,    &k.fy,    &k.cx,    &k.cy,    &lens.k1, &lens.k2,
                                         &lens.k3, &lens.k4, &lens.k5, &lens.k6, &lens.p1, &lens.p2};
    for (std::size_t i = 0; i < parameters.size(); ++i)
    {
        const double value = parameters[i];
        const auto name = model.parameters[i];
        if (!std::isfinite(value))
            throw fresco::Error(place + ": the parameter " + std::string(name) + " is not finite");
        if (name == "f")
            k.fx = k.fy = value;
        else if (name == "w" || name == "h")
        {
            camera.is_panorama = true;
            if (value != (name == "w" ? k.width : k.height))
                throw fresco::Error(fmt::format("{}: the parameter {} is {}; expected the size of the picture, {}x{}", place,
                                                name, value, width, height));
        }
        else
            *places[static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())] = value;
    }
    camera.source = std::move(place);
    return camera;
}

Cameras parse_cameras_binary(std::span<const std::byte> bytes, std::string_view source)
{
    ByteCursor cursor(bytes, source);
    Cameras cameras;
    const auto count = cursor.read<std::uint64_t>("the count of cameras");
    for (std::uint64_t i = 0; i < count; ++i)
    {
        const auto place = cursor.place();
        const auto id = cursor.read<std::uint32_t>("a camera");
        const auto& model = camera_model(cursor.read<std::int32_t>("a camera"), place);
        const auto width = cursor.read<std::uint64_t>("a camera");
        const auto height = cursor.read<std::uint64_t>("a camera");
        std::vector<double> parameters;
        for (std::size_t j = 0; j < model.parameters.size(); ++j)
            parameters.push_back(cursor.read<double>("a camera's parameters"));
        if (!cameras.emplace(id, model_camera(model, width, height, parameters, place)).second)
            throw fresco::Error(fmt::format("{}: the camera {} appears twice: the file is damaged; copy it again", place, id));
    }
    cursor.expect_end();
    return cameras;
}

std::vector<ModelImage> parse_images_binary(std::span<const std::byte> bytes, std::string_view source)
{
    ByteCursor cursor(bytes, source);
    std::vector<ModelImage> images;
    const auto count = cursor.read<std::uint64_t>("the count of images");
    for (std::uint64_t i = 0; i < count; ++i)
    {
        ModelImage image;
        image.source = cursor.place();
        cursor.read<std::uint32_t>("an image");
        std::array<double, 7> numbers{};
        for (double& number : numbers)
            number = cursor.read<double>("an image's pose");
        image.world_from_camera = pose_of(numbers, image.source);
        image.camera = cursor.read<std::uint32_t>("an image's camera");
        image.name = cursor.text("an image's name");
        if (image.name.empty())
            throw fresco::Error(image.source + ": the image has no name: the file is damaged; copy it again");
        const auto points = cursor.read<std::uint64_t>("the count of an image's points");
        // Divided, so that a hostile count cannot run over.
        if (points > cursor.left() / point_bytes)
            throw fresco::Error(fmt::format(
                "{}: {} points do not fit into the remaining {} bytes: the file is truncated or damaged; copy it again",
                cursor.place(), points, cursor.left()));
        cursor.take(points * point_bytes, "an image's points");
        images.push_back(std::move(image));
    }
    cursor.expect_end();
    return images;
}

Cameras parse_cameras_text(std::string_view text, std::string_view source)
{
    LineReader lines(text, source);
    Cameras cameras;
    std::optional<std::int64_t> expected;
    while (const auto line = lines.next())
    {
        if (const auto count = announced(*line, "cameras"))
            expected = count;
        const auto words = words_of(*line);
        if (words.empty() || line->starts_with('#'))
            continue;
        const auto place = lines.place();
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
        if (words_of(*line).empty() || line->starts_with('#'))
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

std::vector<RecordedView> model_views(const Cameras& cameras, const std::vector<ModelImage>& images, const fs::path& images_file,
                                      const ViewOptions& options)
{
    if (images.empty())
        throw fresco::Error(images_file.string() + ": the reconstruction has no images: COLMAP placed none of them");
    std::vector<RecordedView> views;
    for (const auto& image : images)
    {
        const auto camera = cameras.find(image.camera);
        if (camera == cameras.end())
            throw fresco::Error(fmt::format("{}: the camera {} is not in the cameras file; use both files of one reconstruction",
                                            image.source, image.camera));
        RecordedView view;
        name_by_picture(view, image.name);
        view.color = options.pictures / image.name;
        if (!options.depth.empty())
            view.depth = (options.depth / image.name).replace_extension(".png");
        if (!options.masks.empty())
        {
            view.mask = options.masks / (image.name + ".png");
            if (!fs::is_regular_file(view.mask))
                view.mask = (options.masks / image.name).replace_extension(".png");
        }
        view.is_panorama = camera->second.is_panorama;
        view.camera = camera->second.intrinsics;
        view.lens = camera->second.lens;
        view.world_from_camera = image.world_from_camera;
        view.source = image.source;
        views.push_back(std::move(view));
    }
    order_by_name(views);
    return views;
}

}  // namespace colmap
