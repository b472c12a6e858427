#include "catch.h"
#include "opencv_codec.h"
#include "picture_info.h"
#include "picture_samples.h"

#include <cmath>
#include <map>
#include <set>

using fresco::Raster16;
using fresco::Raster8;
using namespace image_opencv;
using namespace samples;

namespace
{

template <class T>
fresco::Raster<T> row(int channels, std::vector<T> values)
{
    fresco::Raster<T> raster(static_cast<int>(values.size()) / channels, 1, channels);
    raster.values = std::move(values);
    return raster;
}

}  // namespace

TEST_CASE("Convert: alpha is composited on white, rounded to the nearest")
{
    for (int color = 0; color < 256; ++color)
        for (int alpha = 0; alpha < 256; ++alpha)
        {
            const auto c = static_cast<std::uint8_t>(color);
            const auto out = to_rgb(row<std::uint8_t>(4, {c, 0, 255, static_cast<std::uint8_t>(alpha)}));
            const auto expected = [&](double v) { return std::lround((v * alpha + 255.0 * (255 - alpha)) / 255.0); };
            REQUIRE(out.values[0] == expected(color));
            REQUIRE(out.values[1] == 255 - alpha);
            REQUIRE(out.values[2] == 255);
        }
}

TEST_CASE("Convert: 16 bits are divided by 257, alpha that is kept leaves colors as they are")
{
    CHECK(to_rgb(row<std::uint16_t>(3, {0, 65535, 257 * 100 + 128})).values == std::vector<std::uint8_t>{0, 255, 100});
    CHECK(to_rgb(row<std::uint16_t>(3, {129, 128, 65406})).values == std::vector<std::uint8_t>{1, 0, 254});
    CHECK(to_rgb(row<std::uint16_t>(4, {0, 65535, 257 * 10, 32768})).values == std::vector<std::uint8_t>{127, 255, 132});
    CHECK(to_rgba(row<std::uint16_t>(4, {0, 65535, 129, 128})).values == std::vector<std::uint8_t>{0, 255, 1, 0});
}

TEST_CASE("Convert: the eight orientations")
{
    // The letter-like pattern  1 2 3 / 4 5 6  as stored; expected as EXIF defines where row 0 and column 0 belong.
    Raster8 stored = row<std::uint8_t>(1, {1, 2, 3, 4, 5, 6});
    stored.width = 3;
    stored.height = 2;
    const std::vector<std::vector<std::uint8_t>> expected{{1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1},
                                                          {4, 5, 6, 1, 2, 3}, {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3},
                                                          {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
    for (int orientation = 1; orientation <= 8; ++orientation)
    {
        INFO(orientation);
        const auto shown = oriented(stored, orientation);
        CHECK(shown.width == (orientation < 5 ? 3 : 2));
        CHECK(shown.height == (orientation < 5 ? 2 : 3));
        CHECK(shown.values == expected[static_cast<std::size_t>(orientation - 1)]);
    }
    CHECK(oriented(row<std::uint8_t>(3, {1, 2, 3, 4, 5, 6}), 2).values == std::vector<std::uint8_t>{4, 5, 6, 1, 2, 3});
}

namespace
{

Bytes small_png()
{
    Png png{.width = 2, .height = 2, .color_type = 2};
    png.rows = bytes_of({0, 1, 2, 3, 4, 5, 6, 0, 7, 8, 9, 10, 11, 12});
    png.before_data = chunk("tEXt", bytes_of({'a', 0, 'b'}));
    return file_of(png);
}

void refused_png(const Bytes& bytes, const std::string& reason, Walk walk = Walk::whole)
{
    CHECK_THROWS_WITH(check_png(bytes, "a.png", walk), Contains("a.png: byte ") && Contains(reason));
}

}  // namespace

TEST_CASE("PNG check: size, bits and kind of every allowed type")
{
    const std::map<int, std::set<int>> allowed{
        {0, {1, 2, 4, 8, 16}}, {2, {8, 16}}, {3, {1, 2, 4, 8}}, {4, {8, 16}}, {6, {8, 16}}};
    for (int type = 0; type < 8; ++type)
        for (int bits = 0; bits <= 32; ++bits)
        {
            const auto list = allowed.find(type);
            const bool good = list != allowed.end() && list->second.contains(bits);
            Png png{.width = 640, .height = 480, .bits = bits, .color_type = type};
            INFO("type " << type << ", bits " << bits);
            if (!good)
            {
                refused_png(file_of(png), "not defined", Walk::size);
                continue;
            }
            const auto info = check_png(file_of(png), "a.png", Walk::size);
            CHECK((info.width == 640 && info.height == 480 && info.bits == bits && info.is_gray == (type == 0)));
        }
}

TEST_CASE("PNG check: every flipped bit is found")
{
    const Bytes good = small_png();
    for (std::size_t i = 0; i < good.size(); ++i)
        for (unsigned bit = 0; bit < 8; ++bit)
        {
            Bytes bad = good;
            bad[i] ^= static_cast<std::byte>(1U << bit);
            CHECK_THROWS_AS(check_png(bad, "a.png", Walk::whole), fresco::Error);
        }
}

TEST_CASE("PNG check: more than 300 megapixels are refused by the header alone")
{
    CHECK_NOTHROW(check_png(file_of(Png{.width = 20'000, .height = 10'000}), "a.png", Walk::size));
    refused_png(file_of(Png{.width = 20'000, .height = 15'001}), "20000 x 15001 pixels; at most 300 megapixels", Walk::size);
    refused_png(file_of(Png{.width = 0xFFFFFFFF, .height = 0xFFFFFFFF}), "at most 300 megapixels", Walk::size);
    refused_png(file_of(Png{.width = 0, .height = 5}), "0 x 5 pixels", Walk::size);
    refused_png(file_of(Png{.width = 5, .height = 0}), "5 x 0 pixels", Walk::size);
}

TEST_CASE("PNG check: missing, doubled and misplaced chunks are refused")
{
    Png png{.width = 1, .height = 1, .rows = bytes_of({0, 7})};
    png.with_data = false;
    refused_png(file_of(png), "no IDAT chunk");
    png.with_data = true;
    png.before_data = header_chunk(png);
    refused_png(file_of(png), "a second IHDR chunk");
    png.before_data = chunk("IDAT", {});
    put(png.before_data, chunk("tEXt", {}));
    refused_png(file_of(png), "not consecutive");
    refused_png(file_of(Png{.color_type = 3, .rows = bytes_of({0, 0})}), "PLTE chunk is missing");
    Bytes no_header = png_signature();
    put(no_header, chunk("IDAT", {}));
    refused_png(no_header, "expected an IHDR chunk");
    Bytes endless = png_signature();
    put(endless, header_chunk(Png{}));
    put(endless, 0xFFFFFFF0U, 4);
    put(endless, "IDAT");
    refused_png(endless, "a chunk of 4294967280 bytes");
}

TEST_CASE("PNG check: transparency of gray is read, bytes after the end are left alone")
{
    Bytes file = file_of(Png{.bits = 16, .rows = bytes_of({0, 1, 2}), .before_data = chunk("tRNS", bytes_of({1, 2}))});
    put(file, "appended");
    CHECK(check_png(file, "a.png", Walk::whole).transparent_gray == 258);
}

namespace
{

Bytes small_jpeg()
{
    Bytes thumbnail = bytes_of({'t', 'h', 'u', 'm', 'b', 0xFF, 0xD8, 0xFF, 0xD9, 0xFF, 0xDA});
    return file_of(Jpeg{.blocks_x = 2, .blocks = {{10, 20, 200}, {250, 1, 0}}, .before_frame = segment(0xE2, thumbnail)});
}

void refused_jpeg(const Bytes& bytes, const std::string& reason, Walk walk = Walk::whole)
{
    CHECK_THROWS_WITH(check_jpeg(bytes, "a.jpg", walk), Contains("a.jpg: byte ") && Contains(reason));
}

}  // namespace

TEST_CASE("JPEG check: stuffing, restart markers and fill bytes do not end the data; what follows EOI is left alone")
{
    Bytes file = small_jpeg();
    const Bytes data = bytes_of({0xFF, 0x00, 1, 0xFF, 0xD0, 2, 0xFF, 0xD7, 3, 0xFF, 0xFF, 0xFF});
    file.insert(file.end() - 2, data.begin(), data.end());
    put(file, bytes_of({0, 0, 0xFF, 0xD8, 1}));
    CHECK(check_jpeg(file, "a.jpg", Walk::whole).width == 16);
}

TEST_CASE("JPEG check: more scans than any encoder writes are refused")
{
    const auto with_scans = [](int count)
    {
        Bytes file = small_jpeg();
        const Bytes scan(file.begin() + static_cast<std::ptrdiff_t>(find(file, {0xFF, 0xDA, 0, 12})), file.end() - 2);
        for (int i = 1; i < count; ++i)
            file.insert(file.end() - 2, scan.begin(), scan.end());
        return file;
    };
    CHECK_NOTHROW(check_jpeg(with_scans(100), "a.jpg", Walk::whole));
    refused_jpeg(with_scans(101), "more than 100 scans");
}

TEST_CASE("JPEG check: kinds that would be read wrongly are refused")
{
    const auto with = [](std::initializer_list<int> pattern, std::size_t offset, int value)
    {
        Bytes file = small_jpeg();
        file[find(file, pattern) + offset] = static_cast<std::byte>(value);
        return file;
    };
    for (const int lossless : {0xC3, 0xC5, 0xC9, 0xCA, 0xCF})
        refused_jpeg(with({0xFF, 0xC0}, 1, lossless), "expected baseline or progressive");
    CHECK_NOTHROW(check_jpeg(file_of(Jpeg{.blocks = {{0}}, .width = 20'000, .height = 10'000}), "a.jpg", Walk::size));
    refused_jpeg(file_of(Jpeg{.blocks = {{0}}, .width = 65'000, .height = 65'000}), "at most 300 megapixels", Walk::size);
    refused_jpeg(with({0xFF, 0xC0}, 4, 12), "12 bits per sample");
    refused_jpeg(with({0xFF, 0xC0}, 6, 0), "16 x 0 pixels");
    refused_jpeg(with({0xFF, 0xC0}, 9, 2), "wrong length");
    refused_jpeg(file_of(Jpeg{.blocks = {{1, 2}}}), "2 color components");
    refused_jpeg(file_of(Jpeg{.blocks = {{1, 2, 3, 4}}}), "CMYK picture without an Adobe marker");
    CHECK_NOTHROW(check_jpeg(file_of(Jpeg{.blocks = {{1, 2, 3, 4}}, .before_frame = adobe_segment(0)}), "a.jpg", Walk::whole));
}

TEST_CASE("JPEG check: segments that contradict each other are refused")
{
    refused_jpeg(bytes_of({'G', 'I', 'F', '8'}), "expected the marker SOI");
    refused_jpeg(bytes_of({0xFF, 0xD8, 0xFF, 0xD9}), "has no data");
    refused_jpeg(bytes_of({0xFF, 0xD8, 0x12, 0x34}), "expected a marker");
    refused_jpeg(bytes_of({0xFF, 0xD8, 0xFF, 0xD8}), "unexpected marker");
    refused_jpeg(bytes_of({0xFF, 0xD8, 0xFF, 0xE0, 0, 1}), "a segment of 1 bytes");
    refused_jpeg(bytes_of({0xFF, 0xD8, 0xFF, 0xDA, 0, 2}), "before the frame header");
    const Bytes good = small_jpeg();
    const auto frame = static_cast<std::ptrdiff_t>(find(good, {0xFF, 0xC0}));
    Bytes twice(good.begin(), good.begin() + frame + 19);
    twice.insert(twice.end(), good.begin() + frame, good.end());
    refused_jpeg(twice, "a second frame header");
    Bytes no_scan(good.begin(), good.begin() + frame + 19);
    put(no_scan, bytes_of({0xFF, 0xD9}));
    refused_jpeg(no_scan, "has no data");
}

TEST_CASE("EXIF: the orientation of both byte orders, 1 for anything malformed")
{
    for (int orientation = 1; orientation <= 8; ++orientation)
        for (const bool big_endian : {false, true})
            CHECK(exif_orientation(tiff_orientation(orientation, big_endian)) == orientation);
    const Bytes good = tiff_orientation(6, true);
    for (std::size_t size = 0; size < 20; ++size)
        CHECK(exif_orientation(std::span(good).first(size)) == 1);
    CHECK(exif_orientation(tiff_orientation(0, true)) == 1);
    CHECK(exif_orientation(tiff_orientation(9, false)) == 1);
}
