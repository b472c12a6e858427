#pragma once

#include "stored_png.h"

#include <algorithm>
#include <bit>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file PNG and JPEG files written byte by byte, so that every kind a person may bring can be tested with exact values.

namespace samples
{

using Bytes = std::vector<std::byte>;

inline void put(Bytes& out, std::uint64_t value, int size)
{
    for (int i = size - 1; i >= 0; --i)
        out.push_back(static_cast<std::byte>(value >> (8 * i)));
}
inline void put(Bytes& out, std::span<const std::byte> bytes)
{
    out.insert(out.end(), bytes.begin(), bytes.end());
}
inline void put(Bytes& out, std::string_view text)
{
    put(out, std::as_bytes(std::span(text.data(), text.size())));
}
inline Bytes bytes_of(std::initializer_list<int> values)
{
    Bytes bytes;
    for (const int v : values)
        put(bytes, static_cast<std::uint64_t>(v), 1);
    return bytes;
}

// ---- PNG

inline Bytes to_bytes(const std::vector<std::uint8_t>& numbers)
{
    const auto bytes = std::as_bytes(std::span(numbers));
    return {bytes.begin(), bytes.end()};
}

inline std::vector<std::uint8_t> numbers_of(std::span<const std::byte> bytes)
{
    const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
    return {first, first + bytes.size()};
}

inline Bytes chunk(const char* type, std::span<const std::byte> data)
{
    std::vector<std::uint8_t> out;
    stored_png::put_chunk(out, type, numbers_of(data));
    return to_bytes(out);
}

/// The chunk of a color profile.
inline Bytes profile_chunk(std::span<const std::byte> icc)
{
    Bytes data = bytes_of({'p', '3', 0, 0});
    put(data, to_bytes(stored_png::zlib(numbers_of(icc))));
    return chunk("iCCP", data);
}

struct Png
{
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    int bits = 8;
    int color_type = 0;
    Bytes rows{};         ///< Each row: a filter byte 0 and its samples.
    Bytes before_data{};  ///< Whole chunks between IHDR and IDAT.
    bool with_data = true;
};

inline Bytes header_chunk(const Png& png)
{
    Bytes header;
    put(header, png.width, 4);
    put(header, png.height, 4);
    put(header, bytes_of({png.bits, png.color_type, 0, 0, 0}));
    return chunk("IHDR", header);
}

inline Bytes png_signature()
{
    return bytes_of({0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'});
}

inline Bytes file_of(const Png& png)
{
    Bytes out = png_signature();
    put(out, header_chunk(png));
    put(out, png.before_data);
    if (png.with_data)
        put(out, chunk("IDAT", to_bytes(stored_png::zlib(numbers_of(png.rows)))));
    put(out, chunk("IEND", {}));
    return out;
}

// ---- EXIF

inline Bytes tiff_orientation(int orientation, bool big_endian)
{
    if (big_endian)
        return bytes_of({'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0, 0, 0, 0, 0});
    return bytes_of({'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 0x12, 0x01, 3, 0, 1, 0, 0, 0, orientation, 0, 0, 0, 0, 0, 0, 0});
}

// ---- JPEG

inline Bytes segment(int marker, std::span<const std::byte> data)
{
    Bytes out = bytes_of({0xFF, marker});
    put(out, data.size() + 2, 2);
    put(out, data);
    return out;
}

/// A baseline JPEG of blocks of 8 x 8 pixels of one color each: only DC coefficients, quantized by 8, so that a sample of a
/// component is exactly its DC value + 128.
struct Jpeg
{
    int blocks_x = 1;
    int blocks_y = 1;
    std::vector<std::vector<int>> blocks{};  ///< Row by row: one value 0..255 per component.
    Bytes before_frame{};                    ///< Whole segments after SOI (JFIF, EXIF, Adobe).
    int width = 0;                           ///< Claimed in the header; 0: 8 * blocks_x.
    int height = 0;
};

inline Bytes adobe_segment(int transform)
{
    return segment(0xEE, bytes_of({'A', 'd', 'o', 'b', 'e', 0, 100, 0, 0, 0, 0, transform}));
}

inline Bytes exif_segment(std::span<const std::byte> tiff)
{
    Bytes data = bytes_of({'E', 'x', 'i', 'f', 0, 0});
    put(data, tiff);
    return segment(0xE1, data);
}

inline Bytes scan_of(const Jpeg& jpeg)
{
    std::string bits;
    const auto write = [&](unsigned value, int count)
    { bits += std::bitset<16>(value).to_string().substr(16U - unsigned(count)); };
    std::vector<int> last(jpeg.blocks.front().size(), 0);
    for (const auto& block : jpeg.blocks)
        for (std::size_t c = 0; c < block.size(); ++c)
        {
            const int dc = block[c] - 128;
            const int difference = dc - last[c];
            last[c] = dc;
            const int category = std::bit_width(static_cast<unsigned>(std::abs(difference)));
            write(static_cast<unsigned>(category), 4);  // code word of a category: its number in 4 bits
            write(static_cast<unsigned>(difference < 0 ? difference + (1 << category) - 1 : difference), category);
            write(0, 1);  // end of block
        }
    // The last byte is filled with ones, as the format wants, and a 0 follows each 255.
    bits.append((8 - bits.size() % 8) % 8, '1');
    Bytes bytes;
    for (std::size_t i = 0; i < bits.size(); i += 8)
    {
        const auto byte = std::bitset<8>(bits, i, 8).to_ulong();
        put(bytes, byte, 1);
        if (byte == 0xFF)
            put(bytes, 0, 1);
    }
    return bytes;
}

inline Bytes file_of(const Jpeg& jpeg)
{
    const auto components = static_cast<int>(jpeg.blocks.front().size());
    Bytes out = bytes_of({0xFF, 0xD8});
    put(out, jpeg.before_frame);
    Bytes table = bytes_of({0});
    table.resize(65, std::byte{8});
    put(out, segment(0xDB, table));
    Bytes frame = bytes_of({8});
    put(frame, static_cast<std::uint64_t>(jpeg.height != 0 ? jpeg.height : 8 * jpeg.blocks_y), 2);
    put(frame, static_cast<std::uint64_t>(jpeg.width != 0 ? jpeg.width : 8 * jpeg.blocks_x), 2);
    put(frame, bytes_of({components}));
    Bytes scan = bytes_of({components});
    for (int c = 1; c <= components; ++c)
    {
        put(frame, bytes_of({c, 0x11, 0}));
        put(scan, bytes_of({c, 0}));
    }
    put(out, segment(0xC0, frame));
    // DC: ten code words of 4 bits for the categories 0 to 9. AC: one code word of 1 bit for the end of the block.
    put(out, segment(0xC4, bytes_of({0x00, 0, 0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9})));
    put(out, segment(0xC4, bytes_of({0x10, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})));
    put(scan, bytes_of({0, 63, 0}));
    put(out, segment(0xDA, scan));
    put(out, scan_of(jpeg));
    put(out, bytes_of({0xFF, 0xD9}));
    return out;
}

// ---- WebP

inline Bytes riff_chunk(std::string_view type, std::span<const std::byte> data)
{
    Bytes out;
    put(out, type);
    for (int i = 0; i < 4; ++i)
        put(out, data.size() >> (8 * i), 1);
    put(out, data);
    out.resize(out.size() + data.size() % 2);
    return out;
}

/// `chunks`: whole chunks one after another.
inline Bytes riff(std::span<const std::byte> chunks)
{
    Bytes data;
    put(data, "WEBP");
    put(data, chunks);
    return riff_chunk("RIFF", data);
}

/// VP8X, then `before`, the image of a plain `webp`, and `behind`. `flags`: RFC 9649, figure 7.
inline Bytes extended_webp(int flags, int width, int height, std::span<const std::byte> before, const Bytes& webp,
                           std::span<const std::byte> behind = {})
{
    const auto low = [](int v) { return (v - 1) & 255; };
    const auto high = [](int v) { return (v - 1) >> 8; };
    Bytes chunks = riff_chunk("VP8X", bytes_of({flags, 0, 0, 0, low(width), high(width), 0, low(height), high(height), 0}));
    put(chunks, before);
    put(chunks, std::span(webp).subspan(12));
    put(chunks, behind);
    return riff(chunks);
}

/// Offset of the first `pattern`; past the end if there is none.
inline std::size_t find(const Bytes& bytes, std::initializer_list<int> pattern)
{
    return static_cast<std::size_t>(std::ranges::search(bytes, bytes_of(pattern)).begin() - bytes.begin());
}

}  // namespace samples
