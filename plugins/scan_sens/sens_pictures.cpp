#include "sens_pictures.h"

#include "sens_depth.h"

#include <fresco/error.h>
#include <fresco/files_io.h>

#include <cstring>
#include <fmt/format.h>

namespace sens
{
namespace
{

namespace fs = std::filesystem;

/// What packed data may have beyond the pixels' own: no packing enlarges them by more.
constexpr std::uint64_t packing_loss = 65536;

std::string place_of(const SensFile& file, std::uint64_t offset, const std::string& name)
{
    return fmt::format("{}: byte {}, {}", file.path().string(), offset, name);
}

std::uint64_t raw_bytes(const SensCamera& camera, std::uint64_t pixel_bytes)
{
    return pixel_bytes * static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
}

/// The packed picture, unless it is larger than a picture of this size can be.
std::vector<std::byte> packed(const SensFile& file, std::uint64_t offset, std::uint64_t bytes, const SensCamera& camera,
                              std::uint64_t pixel_bytes, const std::string& name)
{
    if (bytes > 2 * raw_bytes(camera, pixel_bytes) + packing_loss)
        throw fresco::Error(fmt::format("{}: {} bytes for a picture of {}x{}: the file is damaged; copy it again",
                                        place_of(file, offset, name), bytes, camera.width, camera.height));
    return file.read_at(offset, bytes, name);
}

/// Raw values of exactly the picture's size, which is checked before it takes memory.
template <class T>
fresco::Raster<T> raw(const std::vector<std::byte>& bytes, const SensCamera& camera, int channels, const std::string& place)
{
    if (const auto expected = raw_bytes(camera, sizeof(T) * static_cast<std::uint64_t>(channels)); bytes.size() != expected)
        throw fresco::Error(fmt::format("{}: {} bytes; expected a raw picture of {} bytes: the file is damaged; copy it again",
                                        place, bytes.size(), expected));
    fresco::Raster<T> picture(camera.width, camera.height, channels);
    std::memcpy(picture.values.data(), bytes.data(), bytes.size());
    return picture;
}

}  // namespace

fs::path write_color(const SensFile& file, const SensIndex& index, const SensFrame& frame, const fresco::ImageIo& images,
                     const fs::path& folder, const std::string& name)
{
    const auto bytes = packed(file, frame.color_offset, frame.color_bytes, index.color, 3, name);
    auto written = folder / (name + (index.color_form == ColorForm::jpeg ? ".color.jpg" : ".color.png"));
    if (index.color_form == ColorForm::raw)
    {
        const auto picture = raw<std::uint8_t>(bytes, index.color, 3, place_of(file, frame.color_offset, name));
        fresco::write_file(written, images.encode_png(picture));
    }
    else
        fresco::write_file(written, bytes);
    return written;
}

fs::path write_depth(const SensFile& file, const SensIndex& index, const SensFrame& frame, const fresco::ImageIo& images,
                     const fs::path& folder, const std::string& name)
{
    const auto bytes = packed(file, frame.depth_offset, frame.depth_bytes, index.depth, 2, name);
    const auto place = place_of(file, frame.depth_offset, name);
    auto written = folder / (name + ".depth.png");
    fresco::write_file(written, images.encode_png(index.depth_form == DepthForm::raw
                                                      ? raw<std::uint16_t>(bytes, index.depth, 1, place)
                                                      : unpack_depth(bytes, index.depth.width, index.depth.height, place)));
    return written;
}

}  // namespace sens
