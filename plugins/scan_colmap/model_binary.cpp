#include "model.h"

#include <fresco/error.h>
#include <fresco/recordings/byte_cursor.h>
#include <fresco/recordings/text_records.h>

#include <array>
#include <fmt/format.h>

namespace colmap
{
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
