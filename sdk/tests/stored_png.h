#pragma once

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// An image codec for tests that must not depend on a plugin: writes valid PNG without compressing (zlib "stored" blocks) and
/// reads back what it wrote. Everything else is refused.
namespace stored_png
{

inline void put_be32(std::vector<std::uint8_t>& out, std::uint32_t v)
{
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(static_cast<std::uint8_t>(v >> shift));
}

inline std::uint32_t crc32(const std::uint8_t* bytes, std::size_t count)
{
    std::uint32_t crc = 0xffffffffU;
    for (std::size_t i = 0; i < count; ++i)
    {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit)
            crc = (crc >> 1U) ^ (crc & 1U ? 0xedb88320U : 0U);
    }
    return ~crc;
}

inline void put_chunk(std::vector<std::uint8_t>& out, const char* type, const std::vector<std::uint8_t>& data)
{
    put_be32(out, static_cast<std::uint32_t>(data.size()));
    const std::size_t begin = out.size();
    out.insert(out.end(), type, type + 4);
    out.insert(out.end(), data.begin(), data.end());
    put_be32(out, crc32(out.data() + begin, out.size() - begin));
}

/// Bytes as zlib packs them (RFC 1950), in blocks that are stored as they are.
inline std::vector<std::uint8_t> zlib(const std::vector<std::uint8_t>& bytes)
{
    std::vector<std::uint8_t> packed{0x78, 0x01};
    std::uint32_t a = 1;
    std::uint32_t b = 0;
    for (std::size_t begin = 0; begin < bytes.size(); begin += 65535)
    {
        const std::size_t length = std::min<std::size_t>(65535, bytes.size() - begin);
        packed.push_back(begin + length == bytes.size() ? 1 : 0);
        for (const std::size_t v : {length, length >> 8U, ~length, ~length >> 8U})
            packed.push_back(static_cast<std::uint8_t>(v & 255U));
        for (std::size_t i = begin; i < begin + length; ++i)
        {
            packed.push_back(bytes[i]);
            a = (a + bytes[i]) % 65521;
            b = (b + a) % 65521;
        }
    }
    put_be32(packed, b << 16U | a);
    return packed;
}

inline std::vector<std::uint8_t> encode(const fresco::Raster8& image)
{
    std::vector<std::uint8_t> rows;
    const std::size_t stride = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
    for (int y = 0; y < image.height; ++y)
    {
        rows.push_back(0);
        const auto row = image.values.begin() + static_cast<std::ptrdiff_t>(stride) * y;
        rows.insert(rows.end(), row, row + static_cast<std::ptrdiff_t>(stride));
    }
    std::vector<std::uint8_t> header;
    put_be32(header, static_cast<std::uint32_t>(image.width));
    put_be32(header, static_cast<std::uint32_t>(image.height));
    const std::array<std::uint8_t, 5> color_type{0, 0, 0, 2, 6};
    header.insert(header.end(), {8, color_type.at(static_cast<std::size_t>(image.channels)), 0, 0, 0});
    std::vector<std::uint8_t> out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    put_chunk(out, "IHDR", header);
    put_chunk(out, "IDAT", zlib(rows));
    put_chunk(out, "IEND", {});
    return out;
}

/// The picture of bytes that encode() made; throws fresco::Error for any other PNG.
inline fresco::Raster8 decode(const std::vector<std::uint8_t>& png)
{
    const auto be32 = [&](std::size_t at)
    { return std::uint32_t{png.at(at)} << 24U | png.at(at + 1) << 16U | png.at(at + 2) << 8U | png.at(at + 3); };
    const int channels = png.at(25) == 6 ? 4 : png.at(25) == 2 ? 3 : 1;
    fresco::Raster8 image(static_cast<int>(be32(16)), static_cast<int>(be32(20)), channels);
    // IHDR ends at 33, behind which are IDAT's length and name, and zlib's header; 5 bytes begin a block.
    constexpr std::size_t begin = 33 + 8 + 2;
    if (png.at(begin) > 1)
        throw fresco::Error("stored_png: this picture is compressed");
    const auto row_byte = [&](std::size_t i) { return png.at(begin + 5 * (i / 65535 + 1) + i); };
    const std::size_t stride = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(channels);
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
        for (std::size_t i = 0; i < stride; ++i)
            image.values[y * stride + i] = row_byte(y * (stride + 1) + 1 + i);
    return image;
}

class Codec : public fresco::ImageIo
{
  public:
    fresco::ImageHeader header(const std::filesystem::path& file) const override
    {
        const fresco::Raster8 picture = read_rgb(file);
        return {picture.width, picture.height, 8, picture.channels == 1};
    }
    fresco::Raster8 read_rgb(const std::filesystem::path& file) const override
    {
        const auto bytes = fresco::read_file(file);
        const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
        return decode({data, data + bytes.size()});
    }
    fresco::Raster16 read_depth(const std::filesystem::path& file) const override { refuse(file.string()); }
    std::vector<std::byte> encode_png(const fresco::Raster8& image) const override
    {
        const auto bytes = encode(image);
        const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
        return {data, data + bytes.size()};
    }
    std::vector<std::byte> encode_png(const fresco::Raster16&) const override { refuse("16-bit PNG"); }
    std::vector<std::byte> encode_jpeg(const fresco::Raster8&, int) const override { refuse("JPEG"); }

  private:
    [[noreturn]] static void refuse(const std::string& what) { throw fresco::Error("stored_png cannot handle " + what); }
};

}  // namespace stored_png
