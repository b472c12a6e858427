#include "map_forms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <zstd.h>

namespace bench
{
namespace
{

using fresco::PackedUvMapBytes;
using fresco::UvMap;

template <class Map, class Visit>
void for_each_raster(Map& map, const Visit& visit)
{
    visit(map.valid.values);
    visit(map.uv.values);
    visit(map.cosine.values);
    visit(map.depth.values);
}

std::vector<std::byte> pack_raw(const UvMap& map)
{
    std::vector<std::byte> bytes;
    for_each_raster(map,
                    [&](const auto& values)
                    {
                        const auto raw = std::as_bytes(std::span(values));
                        bytes.insert(bytes.end(), raw.begin(), raw.end());
                    });
    return bytes;
}

UvMap unpack_raw(std::span<const std::byte> bytes, int width, int height)
{
    UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    for_each_raster(map,
                    [&](auto& values)
                    {
                        const std::size_t size = values.size() * sizeof(values[0]);
                        std::memcpy(values.data(), bytes.data(), size);
                        bytes = bytes.subspan(size);
                    });
    return map;
}

PackedUvMapBytes raw_bytes(std::span<const std::byte> bytes)
{
    const std::size_t pixels = bytes.size() / 17;
    return {0, pixels, 8 * pixels, 4 * pixels, 4 * pixels};
}

/// Two frames (low and high bytes) each of u, v, cosine and depth, after one of the validity.
constexpr std::size_t plain_frames = 9;
constexpr std::array<double, 4> plain_scales{65535, 65535, 255, 1000};

std::array<std::uint64_t, plain_frames> plain_sizes(std::span<const std::byte> file)
{
    std::array<std::uint64_t, plain_frames> sizes{};
    std::memcpy(sizes.data(), file.data(), sizeof sizes);
    return sizes;
}

float& value_at(UvMap& map, std::size_t quantity, std::size_t pixel)
{
    return quantity < 2 ? map.uv.values[2 * pixel + quantity] : (quantity == 2 ? map.cosine : map.depth).values[pixel];
}

std::size_t checked(std::size_t size)
{
    if (ZSTD_isError(size) != 0)
        throw std::runtime_error(ZSTD_getErrorName(size));
    return size;
}

std::vector<std::byte> pack_plain(const UvMap& source)
{
    UvMap map = source;
    const auto width = static_cast<std::size_t>(map.valid.width);
    const std::size_t pixels = map.valid.values.size();
    std::array<std::uint64_t, plain_frames> sizes{};
    std::vector<std::byte> file(sizeof sizes);
    std::size_t next = 0;
    const auto append = [&](const std::vector<std::uint8_t>& plane)
    {
        const std::size_t begin = file.size();
        file.resize(begin + ZSTD_compressBound(plane.size()));
        sizes[next] =
            checked(ZSTD_compress(file.data() + begin, file.size() - begin, plane.data(), plane.size(), ZSTD_CLEVEL_DEFAULT));
        file.resize(begin + sizes[next++]);
    };
    append(map.valid.values);
    std::vector<std::uint16_t> steps(pixels);
    std::vector<std::uint8_t> low(pixels);
    std::vector<std::uint8_t> high(pixels);
    for (std::size_t quantity = 0; quantity < plain_scales.size(); ++quantity)
    {
        for (std::size_t i = 0; i < pixels; ++i)
            steps[i] = static_cast<std::uint16_t>(static_cast<double>(value_at(map, quantity, i)) * plain_scales[quantity] + 0.5);
        for (std::size_t i = 0; i < pixels; ++i)
        {
            const int left = i % width > 0 ? steps[i - 1] : 0;
            const int above = i >= width ? steps[i - width] : 0;
            const int corner = i % width > 0 && i >= width ? steps[i - width - 1] : 0;
            const auto difference = static_cast<std::int16_t>(steps[i] - (left + above - corner));
            const auto folded = static_cast<std::uint16_t>(difference * 2 ^ (difference < 0 ? -1 : 0));
            low[i] = static_cast<std::uint8_t>(folded & 255U);
            high[i] = static_cast<std::uint8_t>(folded >> 8U);
        }
        append(low);
        append(high);
    }
    std::memcpy(file.data(), sizes.data(), sizeof sizes);
    return file;
}

UvMap unpack_plain(std::span<const std::byte> file, int width, int height)
{
    UvMap map{{width, height, 2}, {width, height}, {width, height}, {width, height}};
    const auto columns = static_cast<std::size_t>(width);
    const std::size_t pixels = map.valid.values.size();
    const auto sizes = plain_sizes(file);
    std::size_t at = sizeof sizes;
    std::size_t next = 0;
    const auto fetch = [&](std::vector<std::uint8_t>& plane)
    {
        checked(ZSTD_decompress(plane.data(), plane.size(), file.data() + at, sizes[next]));
        at += sizes[next++];
    };
    fetch(map.valid.values);
    std::vector<std::uint16_t> steps(pixels);
    std::vector<std::uint8_t> low(pixels);
    std::vector<std::uint8_t> high(pixels);
    for (std::size_t quantity = 0; quantity < plain_scales.size(); ++quantity)
    {
        fetch(low);
        fetch(high);
        const auto scale = static_cast<float>(plain_scales[quantity]);
        for (std::size_t i = 0; i < pixels; ++i)
        {
            const int left = i % columns > 0 ? steps[i - 1] : 0;
            const int above = i >= columns ? steps[i - columns] : 0;
            const int corner = i % columns > 0 && i >= columns ? steps[i - columns - 1] : 0;
            const int folded = low[i] + 256 * high[i];
            steps[i] = static_cast<std::uint16_t>(left + above - corner + (folded / 2 ^ -(folded & 1)));
            value_at(map, quantity, i) = static_cast<float>(steps[i]) / scale;
        }
    }
    return map;
}

PackedUvMapBytes plain_bytes(std::span<const std::byte> file)
{
    const auto sizes = plain_sizes(file);
    return {sizeof sizes, sizes[0], sizes[1] + sizes[2] + sizes[3] + sizes[4], sizes[5] + sizes[6], sizes[7] + sizes[8]};
}

MapForm packed(const char* name, int uv_bits)
{
    return {name, [uv_bits](const UvMap& map) { return fresco::pack_uv_map(map, uv_bits, "bench"); },
            [](std::span<const std::byte> file, int width, int height)
            { return fresco::unpack_uv_map(file, width, height, "bench"); },
            [](std::span<const std::byte> file) { return fresco::packed_uv_map_bytes(file, "bench"); }};
}

}  // namespace

const std::vector<MapForm>& map_forms()
{
    static const std::vector<MapForm> forms{{"raw float32", pack_raw, unpack_raw, raw_bytes},
                                            {"16 bits, gradient, byte split, zstd", pack_plain, unpack_plain, plain_bytes},
                                            packed("the store's", fresco::min_uv_bits),
                                            packed("the store's, for 16384 texels", fresco::uv_bits_for_texture(16384))};
    return forms;
}

}  // namespace bench
