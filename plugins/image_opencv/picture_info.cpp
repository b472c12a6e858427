#include "picture_info.h"

#include <fresco/files_io.h>

#include <fmt/format.h>
#include <fstream>
#include <vector>

namespace image_opencv
{
namespace
{

// Holds the size of any PNG and of all JPEGs but those with large thumbnails before it.
constexpr std::size_t prefix_bytes = std::size_t{1} << 16U;

std::vector<std::byte> read_prefix(const std::filesystem::path& file)
{
    std::vector<std::byte> bytes(prefix_bytes);
    std::ifstream stream(file, std::ios::binary);
    if (!stream || std::filesystem::is_directory(file))
        throw fresco::MissingInput(file.string() + ": the picture cannot be opened");
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(stream.gcount()));
    return bytes;
}

}  // namespace

void PictureBytes::check_size(std::size_t at, std::int64_t width, std::int64_t height) const
{
    const auto text = fmt::format("{} x {} pixels", width, height);
    if (width < 1 || height < 1)
        fail(at, "the picture has " + text);
    // Both are below 2^32, so the product may not fit: divide.
    if (width > max_pixels / height)
        fail(at, fmt::format("the picture has {}; at most {} megapixels are supported: shrink it first", text,
                             max_pixels / 1'000'000));
}

PictureInfo check_picture(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    const PictureBytes picture(bytes, source);
    if (picture.u8(0) == 0x89)
        return check_png(bytes, source, walk);
    if (picture.u8(0) == 0xFF)
        return check_jpeg(bytes, source, walk);
    picture.fail(0, "neither a PNG nor a JPEG file; convert the picture to one of them");
}

PictureInfo picture_size(const std::filesystem::path& file)
{
    const auto prefix = read_prefix(file);
    if (prefix.size() == prefix_bytes)
    {
        try
        {
            return check_picture(prefix, file.string(), Walk::size);
        }
        catch (const CutPicture&)
        {
            return check_picture(fresco::read_file(file), file.string(), Walk::size);
        }
    }
    return check_picture(prefix, file.string(), Walk::size);
}

}  // namespace image_opencv
