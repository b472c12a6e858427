#include "parsers.h"

#include "sdk/src/packed_uv_map.h"
#include "sdk/src/residuals.h"

#include <fresco/uv_maps.h>

#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace fresco::fuzz
{
namespace
{

using detail::PackedUvMapHeader;

/// Larger maps are refused by the index beside them, or are of their size.
constexpr std::uint64_t most_pixels = 1U << 20U;

void unpack(std::vector<std::byte> file)
{
    if (file.size() < PackedUvMapHeader::bytes)
    {
        (void)PackedUvMapHeader::read(file, source);
        return;
    }
    // The checksum of the header, without which nothing behind it would be reached.
    constexpr std::size_t at = PackedUvMapHeader::bytes - 4;
    const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(file.data()), at));
    std::memcpy(file.data() + at, &sum, 4);
    const PackedUvMapHeader header = PackedUvMapHeader::read(file, source);
    if (std::uint64_t{header.width} * header.height > most_pixels || std::max(header.width, header.height) > most_pixels)
        return;
    const UvMap map = unpack_uv_map(file, static_cast<int>(header.width), static_cast<int>(header.height), source);
    require(map.valid.values.size() == std::size_t{header.width} * header.height, "a value per pixel");
    for (const float u : map.uv.values)
        require(u >= 0 && u <= 1, "texcoords are from 0 to 1");
    const auto parts = packed_uv_map_bytes(file, source);
    (void)parts;
    // What it holds can be packed.
    if (!map.valid.empty())
        unpack_uv_map(pack_uv_map(map, header.bits[0], "its own"), map.valid.width, map.valid.height, "its own");
}

void read_file(Bytes bytes)
{
    unpack({bytes.begin(), bytes.end()});
}

/// Takes the planes of a file out of the bytes, so that Zstandard's own checksums do not keep changes out.
void read_planes(Bytes bytes)
{
    std::size_t next = 0;
    const auto byte = [&] { return next < bytes.size() ? std::to_integer<std::uint8_t>(bytes[next++]) : std::uint8_t{0}; };
    PackedUvMapHeader header;
    header.width = 1U + byte() % 64U;
    header.height = 1U + byte() % 64U;
    const std::uint8_t uv_bits = 16 + byte() % 7;
    header.bits = {uv_bits, uv_bits, 8, byte() % 2 == 0 ? std::uint8_t{16} : std::uint8_t{22}};
    header.depth_steps_per_meter = 1000;
    const std::size_t pixels = std::size_t{header.width} * header.height;
    const auto plane = [&](std::size_t size)
    {
        std::vector<std::uint8_t> values(size);
        std::ranges::generate(values, byte);
        return values;
    };
    detail::FrameWriter frames(PackedUvMapHeader::bytes);
    const auto mask = plane((pixels + 7) / 8);
    std::size_t ones = 0;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
        ones += mask[pixel / 8] >> pixel % 8 & 1U;
    header.valid_pixels = static_cast<std::uint32_t>(ones);
    header.mask = frames.append(mask);
    for (std::size_t i = 0; i < detail::packed_quantities; ++i)
    {
        const auto low = plane(pixels);
        const auto extra = plane(detail::extra_bits(header.bits[i]) > 0 ? pixels : 0);
        const auto large = plane(2 * detail::count_large(low, header.bits[i]));
        header.parts[i] = {frames.append(low), frames.append(extra), frames.append(large)};
    }
    auto file = std::move(frames).bytes();
    std::ranges::copy(header.write(), file.begin());
    unpack(std::move(file));
}

const Registered registered{{"uv_map", "sdk/src/packed_uv_map\\.cpp", read_file},
                            {"uv_map_planes", "sdk/src/(packed_uv_map|residuals)\\.cpp", read_planes}};

}  // namespace
}  // namespace fresco::fuzz
