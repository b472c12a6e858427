#include "model.h"

#include <fresco/error.h>
#include <fresco/recordings/parsing.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace colmap
{
namespace
{

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
        // What forks of COLMAP and PoseLib call it.
        {17, "SPHERICAL", {"w", "h"}},
    };
    return models;
}

/// Those that COLMAP knows beside them, by their ids.
constexpr std::array<std::pair<std::int32_t, std::string_view>, 6> other_models{{{7, "FOV"},
                                                                                 {10, "THIN_PRISM_FISHEYE"},
                                                                                 {11, "RAD_TAN_THIN_PRISM_FISHEYE"},
                                                                                 {12, "SIMPLE_DIVISION"},
                                                                                 {13, "DIVISION"},
                                                                                 {16, "EUCM"}}};

[[noreturn]] void refuse(const std::string& model, const std::string& place)
{
    std::string names;
    for (const auto& known : read_models())
        names += (names.empty() ? "" : ", ") + std::string(known.name);
    throw fresco::Error(place + ": camera model " + model + " is not supported; expected " + names +
                        ": undistort with \"colmap image_undistorter\" first");
}

}  // namespace

const CameraModel& camera_model(std::string_view name, const std::string& place)
{
    const auto& models = read_models();
    const auto found = std::find_if(models.begin(), models.end(), [&](const CameraModel& model) { return model.name == name; });
    if (found == models.end())
        refuse("\"" + std::string(name.substr(0, 40)) + "\"", place);
    return *found;
}

const CameraModel& camera_model(std::int32_t id, const std::string& place)
{
    const auto& models = read_models();
    const auto found = std::find_if(models.begin(), models.end(), [&](const CameraModel& model) { return model.id == id; });
    if (found != models.end())
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
    for (std::size_t i = 0; i < parameters.size(); ++i)
    {
        const double value = parameters[i];
        const auto name = model.parameters[i];
        if (!std::isfinite(value))
            throw fresco::Error(place + ": the parameter " + std::string(name) + " is not finite");
        auto& k = camera.intrinsics;
        auto& lens = camera.lens;
        if (name == "f")
            k.fx = k.fy = value;
        if (name == "w" || name == "h")
        {
            camera.is_panorama = true;
            if (value != (name == "w" ? k.width : k.height))
                throw fresco::Error(fmt::format("{}: the parameter {} is {}; expected the size of the picture, {}x{}", place,
                                                name, value, width, height));
        }
        const std::array<std::pair<std::string_view, double*>, 12> places{{{"fx", &k.fx},
                                                                           {"fy", &k.fy},
                                                                           {"cx", &k.cx},
                                                                           {"cy", &k.cy},
                                                                           {"k1", &lens.k1},
                                                                           {"k2", &lens.k2},
                                                                           {"k3", &lens.k3},
                                                                           {"k4", &lens.k4},
                                                                           {"k5", &lens.k5},
                                                                           {"k6", &lens.k6},
                                                                           {"p1", &lens.p1},
                                                                           {"p2", &lens.p2}}};
        for (const auto& [key, target] : places)
            if (key == name)
                *target = value;
    }
    camera.source = std::move(place);
    return camera;
}

namespace
{

using fresco::recordings::ByteCursor;

constexpr std::uint64_t point_bytes = 24;  // Two doubles and a number of 64 bits.

}  // namespace

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
        image.world_from_camera = fresco::recordings::quaternion_transform(numbers[0], numbers[1], numbers[2], numbers[3],
                                                                           {numbers[4], numbers[5], numbers[6]}, image.source)
                                      .inverse();
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

}  // namespace colmap
