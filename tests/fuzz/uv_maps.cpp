#include "parsers.h"
#include "sdk/src/artifact_files.h"

#include <fresco/uv_maps.h>

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

namespace fresco::fuzz
{
namespace
{

constexpr std::size_t header_bytes = 36;
/// Larger maps are refused by the index beside them, or are of their size.
constexpr std::uint64_t most_pixels = 1U << 20U;

void unpack(std::vector<std::byte> file)
{
    std::uint32_t size[2] = {1, 1};
    if (file.size() >= header_bytes)
    {
        // The checksum of the header, without which nothing behind it would be reached.
        constexpr std::size_t at = header_bytes - 4;
        const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(file.data()), at));
        std::memcpy(file.data() + at, &sum, 4);
        std::memcpy(size, file.data() + 12, sizeof size);
    }
    if (std::uint64_t{size[0]} * size[1] > most_pixels || std::max(size[0], size[1]) > most_pixels)
        return;
    const UvMap map = unpack_uv_map(file, static_cast<int>(size[0]), static_cast<int>(size[1]), source);
    require(map.valid.values.size() == std::size_t{size[0]} * size[1], "a value per pixel");
    for (const float u : map.uv.values)
        require(u >= 0 && u <= 1, "texcoords are from 0 to 1");
    // Unpacked contents can be packed again.
    unpack_uv_map(pack_uv_map(map, std::to_integer<int>(file[20]), "its own"), map.valid.width, map.valid.height, "its own");
}

void read_file(Bytes bytes)
{
    unpack({bytes.begin(), bytes.end()});
}

/// Takes the frame's contents out of the bytes, so that Zstandard's own checksums do not keep changes out.
void read_planes(Bytes bytes)
{
    std::size_t next = 0;
    const auto byte = [&] { return next < bytes.size() ? std::to_integer<std::uint8_t>(bytes[next++]) : std::uint8_t{0}; };
    const std::uint32_t width = 1U + byte() % 64U;
    const std::uint32_t height = 1U + byte() % 64U;
    const std::uint32_t uv_bits = 16U + byte() % 7U;
    const std::uint32_t depth_bits = byte() % 2 == 0 ? 16 : 22;
    const std::size_t pixels = std::size_t{width} * height;
    std::vector<std::uint8_t> content((pixels + 7) / 8 + pixels * (2 * ((uv_bits + 7) / 8) + 1 + (depth_bits + 7) / 8));
    std::ranges::generate(content, byte);
    std::vector<std::byte> file(header_bytes + ZSTD_compressBound(content.size()));
    file.resize(header_bytes +
                ZSTD_compress(file.data() + header_bytes, file.size() - header_bytes, content.data(), content.size(), 1));
    const std::uint32_t numbers[5] = {3, width, height, uv_bits, depth_bits};
    const float steps_per_meter = 1000;
    std::memcpy(file.data(), "FRESCOUV", 8);
    std::memcpy(file.data() + 8, numbers, sizeof numbers);
    std::memcpy(file.data() + 28, &steps_per_meter, 4);
    unpack(std::move(file));
}

template <class T>
void read_raster_of(Bytes bytes)
{
    Raster<T> raster;
    if (refused([&] { raster = detail::unpack_raster<T>(bytes, source); }))
        return;  // Most are of another type.
    const auto again = detail::unpack_raster<T>(detail::pack_raster(raster, "its own"), "its own");
    // Bits are compared, because a float may be no number.
    require(std::ranges::equal(std::as_bytes(std::span(again.values)), std::as_bytes(std::span(raster.values))),
            "packed and unpacked, the same raster");
}

void read_raster(Bytes bytes)
{
    read_raster_of<std::uint8_t>(bytes);
    read_raster_of<std::uint16_t>(bytes);
    read_raster_of<float>(bytes);
    (void)detail::unpack_raster<float>(bytes, source);
}

const Registered registered{{"raster", "sdk/src/packed\\.cpp", read_raster},
                            {"uv_map", "sdk/src/packed\\.cpp", read_file},
                            {"uv_map_planes", "sdk/src/packed\\.cpp", read_planes}};

}  // namespace
}  // namespace fresco::fuzz
