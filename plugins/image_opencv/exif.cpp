#include "exif.h"

#include <cstdint>

namespace image_opencv
{
namespace
{

constexpr unsigned orientation_tag = 0x0112;
constexpr unsigned type_short = 3;
constexpr std::size_t entry_bytes = 12;

/// Numbers of the block's own byte order; 0 beyond its end.
struct Tiff
{
    std::span<const std::byte> bytes;
    bool big_endian;

    std::uint32_t number(std::size_t at, std::size_t size) const
    {
        if (at > bytes.size() || size > bytes.size() - at)
            return 0;
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < size; ++i)
            value = value << 8U | std::to_integer<std::uint32_t>(bytes[at + (big_endian ? i : size - 1 - i)]);
        return value;
    }
};

}  // namespace

int exif_orientation(std::span<const std::byte> bytes)
{
    if (bytes.size() < 8)
        return 1;
    const Tiff tiff{bytes, bytes[0] == std::byte{'M'}};
    const std::byte mark{static_cast<unsigned char>(tiff.big_endian ? 'M' : 'I')};
    if (bytes[0] != mark || bytes[1] != mark || tiff.number(2, 2) != 42)
        return 1;
    const std::size_t directory = tiff.number(4, 4);
    const std::size_t entries = tiff.number(directory, 2);
    for (std::size_t i = 0; i < entries; ++i)
    {
        const std::size_t entry = directory + 2 + i * entry_bytes;
        if (tiff.number(entry, 2) != orientation_tag)
            continue;
        const auto value = tiff.number(entry + 8, 2);
        return tiff.number(entry + 2, 2) == type_short && value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
    }
    return 1;
}

}  // namespace image_opencv
