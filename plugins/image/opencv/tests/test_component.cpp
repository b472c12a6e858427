#include "catch.h"
#include "codec.h"

#include <fresco/files_io.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <tuple>

using namespace fresco;
using namespace samples;

namespace
{

using Values = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE_METHOD(WithCodec, "image.opencv: every kind of PNG becomes 8-bit RGB")
{
    const Bytes palette = chunk("PLTE", bytes_of({200, 100, 50, 0, 10, 20, 9, 8, 7, 255, 255, 255}));
    const auto rgb = [&](const Png& png) { return codec.rgb(file_of(png)); };
    const auto transparent = [](std::initializer_list<int> color, Bytes before = {})
    {
        put(before, chunk("tRNS", bytes_of(color)));
        return before;
    };
    CHECK(rgb({.width = 2, .rows = bytes_of({0, 7, 9})}) == Values{7, 7, 7, 9, 9, 9});
    // Grays of 1, 2 and 4 bits are spread over 0..255.
    CHECK(rgb({.width = 3, .bits = 1, .rows = bytes_of({0, 0b01000000})}) == Values{0, 0, 0, 255, 255, 255, 0, 0, 0});
    CHECK(rgb({.width = 2, .bits = 2, .rows = bytes_of({0, 0b01100000})}) == Values{85, 85, 85, 170, 170, 170});
    CHECK(rgb({.width = 2, .bits = 4, .rows = bytes_of({0, 0x3A})}) == Values{51, 51, 51, 170, 170, 170});
    CHECK(rgb({.width = 1, .bits = 16, .rows = bytes_of({0, 100, 100})}) == Values{100, 100, 100});
    CHECK(rgb({.color_type = 2, .rows = bytes_of({0, 1, 2, 3})}) == Values{1, 2, 3});
    CHECK(rgb({.bits = 16, .color_type = 2, .rows = bytes_of({0, 1, 1, 2, 2, 3, 3})}) == Values{1, 2, 3});
    CHECK(rgb({.color_type = 4, .rows = bytes_of({0, 100, 51})}) == Values{224, 224, 224});
    CHECK(rgb({.bits = 16, .color_type = 4, .rows = bytes_of({0, 100, 100, 51, 51})}) == Values{224, 224, 224});
    CHECK(rgb({.color_type = 6, .rows = bytes_of({0, 100, 0, 255, 51})}) == Values{224, 204, 255});
    CHECK(rgb({.color_type = 3, .rows = bytes_of({0, 0}), .before_data = palette}) == Values{200, 100, 50});
    CHECK(rgb({.width = 2, .bits = 2, .color_type = 3, .rows = bytes_of({0, 0b00010000}), .before_data = palette}) ==
          Values{200, 100, 50, 0, 10, 20});
    // Transparent colors: of a palette, of RGB, of gray with 2, 8 and 16 bits.
    CHECK(rgb({.width = 2, .color_type = 3, .rows = bytes_of({0, 0, 1}), .before_data = transparent({0}, palette)}) ==
          Values{255, 255, 255, 0, 10, 20});
    CHECK(rgb({.width = 2,
               .color_type = 2,
               .rows = bytes_of({0, 1, 2, 3, 4, 5, 6}),
               .before_data = transparent({0, 1, 0, 2, 0, 3})}) == Values{255, 255, 255, 4, 5, 6});
    CHECK(rgb({.width = 2, .bits = 2, .rows = bytes_of({0, 0b01100000}), .before_data = transparent({0, 1})}) ==
          Values{255, 255, 255, 170, 170, 170});
    CHECK(rgb({.width = 2, .rows = bytes_of({0, 7, 9}), .before_data = transparent({0, 9})}) == Values{7, 7, 7, 255, 255, 255});
    CHECK(rgb({.width = 2, .bits = 16, .rows = bytes_of({0, 1, 1, 1, 2}), .before_data = transparent({1, 2})}) ==
          Values{1, 1, 1, 255, 255, 255});
    const auto key = codec.write(
        file_of(Png{.width = 2, .bits = 2, .rows = bytes_of({0, 0b01100000}), .before_data = chunk("tRNS", bytes_of({0, 1}))}));
    CHECK(codec.images->check(key).alpha);
    CHECK(codec.images->read_with_alpha(key).values == Values{85, 85, 85, 0, 170, 170, 170, 255});
    CHECK(read_picture(*codec.images, key).channels == 4);
    for (const int alpha : {249, 250})
    {
        const auto file = codec.write(file_of(Png{.color_type = 6, .rows = bytes_of({0, 100, 0, 255, alpha})}));
        CHECK(read_picture(*codec.images, file).channels == (alpha < 250 ? 4 : 3));
        CHECK((alpha < 250 || read_picture(*codec.images, file) == codec.images->read_rgb(file)));
    }
    // Orientation 6: the stored left end is shown at the top.
    const auto turned = codec.images->read_rgb(codec.write(
        file_of(Png{.width = 2, .rows = bytes_of({0, 7, 9}), .before_data = chunk("eXIf", tiff_orientation(6, true))})));
    CHECK(turned.width == 1);
    CHECK(turned.values == Values{7, 7, 7, 9, 9, 9});
}

TEST_CASE_METHOD(WithCodec, "image.opencv: gray, YCbCr, RGB and CMYK JPEG, with the stored orientation")
{
    const auto corner = [&](const Jpeg& jpeg)
    {
        const auto image = codec.images->read_rgb(codec.write(file_of(jpeg)));
        CHECK(image.channels == 3);
        return Values{image.at(0, 0, 0), image.at(0, 0, 1), image.at(0, 0, 2)};
    };
    CHECK(corner({.blocks = {{200}}}) == Values{200, 200, 200});
    CHECK(corner({.blocks = {{90, 128, 128}}}) == Values{90, 90, 90});
    // Y 100, Cb 128, Cr 178: R = Y + 1.402 * 50, G = Y - 0.714136 * 50.
    CHECK(corner({.blocks = {{100, 128, 178}}}) == Values{170, 64, 100});
    CHECK(corner({.blocks = {{10, 20, 200}}, .before_frame = adobe_segment(0)}) == Values{10, 20, 200});
    // Adobe's CMYK is inverted: 255 means no ink. R = C K / 255.
    // YCCK (Adobe transform 2) holds the inverse of C, M, Y as YCbCr: gray 55 is C = M = Y = 200.
    for (const auto& [transform, block, expected] : {std::tuple{0, std::vector<int>{255, 255, 255, 255}, Values{255, 255, 255}},
                                                     {0, {200, 100, 50, 255}, {200, 100, 50}},
                                                     {0, {200, 100, 50, 128}, {100, 50, 25}},
                                                     {0, {255, 255, 255, 0}, {0, 0, 0}},
                                                     {2, {55, 128, 128, 255}, {200, 200, 200}}})
        CHECK(std::ranges::equal(corner({.blocks = {block}, .before_frame = adobe_segment(transform)}), expected,
                                 [](int a, int b) { return std::abs(a - b) <= 2; }));
    // The header lies behind a large thumbnail.
    Bytes before = exif_segment(tiff_orientation(8, false));
    for (int i = 0; i < 3; ++i)
        put(before, segment(0xE2, Bytes(60'000)));
    const auto turned = codec.write(file_of(Jpeg{.blocks_x = 2, .blocks = {{10}, {250}}, .before_frame = before}));
    CHECK(codec.images->header(turned).orientation == 8);
    CHECK(codec.images->read_rgb(turned).at(0, 0) == 250);
}

TEST_CASE_METHOD(WithCodec, "image.opencv: the check reports the kind of samples and refuses a truncated file, without decoding")
{
    const auto deep = codec.images->encode_png(Raster16(7, 5, 1, 300));
    const auto header = codec.images->check(codec.write(deep));
    CHECK((header.width == 7 && header.height == 5 && header.bits == 16 && header.gray));
    const auto colors = codec.images->check(codec.write(codec.images->encode_jpeg(pattern(19, 9, 3), 80)));
    CHECK((colors.bits == 8 && !colors.gray && !colors.alpha));
    CHECK(codec.images->check(codec.write(file_of(Jpeg{.blocks = {{10}}}))).gray);
    for (const int channels : {3, 4})
        CHECK(codec.images->check(codec.write(codec.images->encode_png(pattern(3, 2, channels)))).alpha == (channels == 4));
    const auto cut = codec.write(Bytes(deep.begin(), deep.end() - 1));
    CHECK_THROWS_AS(codec.images->check(cut), Error);
    CHECK(codec.images->header(cut).width == 7);
}

TEST_CASE_METHOD(WithCodec, "image.opencv: pictures cut at any byte are refused")
{
    refuses_every_beginning(codec, codec.images->encode_png(pattern(5, 4, 3)));
    refuses_every_beginning(codec, codec.images->encode_jpeg(pattern(19, 9, 3), 80));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: BMP of 24, 32 and 8 bits, upward and downward; the fourth byte of a pixel is no alpha")
{
    const Raster8 image = pattern(5, 3, 3);
    const auto bmp = [&](int bits, bool down, std::uint32_t compression = 0)
    {
        Bytes file;
        const auto little = [&](std::uint32_t value, int size)
        {
            for (int i = 0; i < size; ++i)
                put(file, value >> 8U * static_cast<unsigned>(i) & 255U, 1);
        };
        const std::uint32_t head = 54 + (bits == 8 ? 1024 : compression == 3 ? 12 : 0);
        put(file, "BM");
        for (const std::uint32_t value : {head + 60, 0U, head, 40U, 5U, down ? static_cast<std::uint32_t>(-3) : 3U})
            little(value, 4);
        little(1, 2);
        little(static_cast<std::uint32_t>(bits), 2);
        for (const std::uint32_t value : {compression, 0U, 0U, 0U, 0U, 0U})
            little(value, 4);
        for (const std::uint32_t mask : {0xFF0000U, 0xFF00U, 0xFFU})
            little(mask, compression == 3 ? 4 : 0);
        for (std::uint32_t color = 0; color < (bits == 8 ? 256U : 0U); ++color)
            little(color * 0x10101U, 4);
        for (int row = 0; row < 3; ++row)
        {
            for (int x = 0; x < 5; ++x)
                for (int c = 0; c < bits / 8; ++c)
                    put(file, c == 3 ? 7 : image.at(x, down ? row : 2 - row, bits == 8 ? 0 : 2 - c), 1);
            while ((file.size() - head) % 4 != 0)
                put(file, 0, 1);
        }
        return file;
    };
    for (const int bits : {24, 32})
        for (const bool down : {false, true})
            CHECK(codec.rgb(bmp(bits, down)) == image.values);
    CHECK(codec.rgb(bmp(32, false, 3)) == image.values);
    CHECK(codec.images->read_rgb(codec.write(bmp(8, false))).at(4, 2, 1) == image.at(4, 2, 0));
    refuses_every_beginning(codec, bmp(24, false));
    CHECK_THROWS_WITH(codec.rgb(bmp(16, false)), Contains("byte 28: a BMP picture of 16 bits, compression 0; save it as PNG"));
    CHECK_THROWS_WITH(codec.rgb(bmp(8, false, 1)), Contains("compression 1"));
    Bytes inside = bmp(8, false);
    inside[11] = std::byte{0};
    CHECK_THROWS_WITH(codec.rgb(inside), Contains("byte 10: the pixels begin inside the header"));
    CHECK_THROWS_WITH(codec.rgb(to_bytes({0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB})), Contains("byte 0: a KTX2 texture"));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: errors name the file and what to do")
{
    CHECK_THROWS_AS(codec.images->read_rgb(codec.folder() / "none.png"), MissingInput);
    CHECK_THROWS_AS(codec.images->header(codec.folder() / "none.png"), MissingInput);
    CHECK_THROWS_AS(codec.images->header(codec.folder()), Error);
    const auto gif = codec.write(bytes_of({'G', 'I', 'F', '8', '9', 'a'}), "picture.gif");
    CHECK_THROWS_WITH(codec.images->read_rgb(gif),
                      Contains("picture.gif") && Contains("not a PNG, JPEG, WebP, HEIC, AVIF or BMP file"));
    CHECK_THROWS_WITH(codec.images->header(gif), Contains("not a PNG, JPEG, WebP, HEIC, AVIF or BMP file"));
    CHECK_THROWS_AS(codec.images->read_rgb(codec.write({})), Error);
    CHECK_THROWS_WITH(codec.rgb(file_of(Png{.width = 30'000, .height = 30'000})), Contains("at most 300 megapixels"));
    // Damage that no checksum shows: two rows are claimed, one is there; a filter that does not exist.
    for (const Png& png : {Png{.width = 2, .height = 2, .rows = bytes_of({0, 7, 9})}, {.width = 2, .rows = bytes_of({9, 7, 9})}})
        CHECK_THROWS_WITH(codec.rgb(file_of(png)), Contains("cannot be decoded"));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: depth is read as stored, other pictures are refused")
{
    const auto depth =
        codec.images->read_depth(codec.write(file_of(Png{.width = 2, .bits = 16, .rows = bytes_of({0, 1, 2, 0xFF, 0xFF})})));
    CHECK(depth.values == std::vector<std::uint16_t>{258, 65535});
    Raster16 other(2, 1);
    other.values = {3, 40'000};
    CHECK(codec.images->read_depth(codec.write(codec.images->encode_png(other))) == other);
    const auto refused = [&](const Bytes& bytes)
    { CHECK_THROWS_WITH(codec.images->read_depth(codec.write(bytes)), Contains("expected a depth picture")); };
    refused(file_of(Png{.rows = bytes_of({0, 7})}));
    refused(file_of(Png{.bits = 16, .color_type = 2, .rows = bytes_of({0, 1, 1, 2, 2, 3, 3})}));
    refused(file_of(Jpeg{.blocks = {{7}}}));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: PNG gives the same pixels back, the same pixels the same bytes")
{
    for (const int channels : {1, 3})
    {
        const auto image = pattern(31, 17, channels);
        const auto bytes = codec.images->encode_png(image);
        CHECK(bytes == codec.images->encode_png(image));
        CHECK(codec.images->read_rgb(codec.write(bytes)) ==
              testing::picture(31, 17, [&](int x, int y, int c) { return image.at(x, y, channels == 1 ? 0 : c); }));
    }
    for (const int channels : {3, 4})
        CHECK(codec.images->read_with_alpha(codec.write(codec.images->encode_png(pattern(3, 2, channels)))) ==
              pattern(3, 2, channels));
    Raster16 deep(1, 1, 3);
    deep.values = {257, 514, 65535};
    CHECK(codec.rgb(codec.images->encode_png(deep)) == Values{1, 2, 255});
}

TEST_CASE_METHOD(WithCodec, "image.opencv: JPEG is close to the pixels, smaller at lower quality, the same each time")
{
    const Raster8 image = testing::picture(32, 32, [](int x, int y, int c) { return c == 0 ? 8 * x : c == 1 ? 8 * y : 30; });
    const auto good = codec.images->encode_jpeg(image, 95);
    CHECK(good == codec.images->encode_jpeg(image, 95));
    CHECK(codec.images->encode_jpeg(image, 20).size() < good.size());
    const auto apart = [](double a, double b) { return std::abs(a - b); };
    CHECK(std::transform_reduce(image.values.begin(), image.values.end(), codec.rgb(good).begin(), 0.0, std::plus(), apart) <
          3.0 * 3 * 32 * 32);
    Raster8 gray(8, 8, 1, 77);
    CHECK(codec.images->read_rgb(codec.write(codec.images->encode_jpeg(gray, 100))) == Raster8(8, 8, 3, 77));
}

TEST_CASE_METHOD(WithCodec, "image.opencv: what cannot be encoded is refused")
{
    CHECK_THROWS_WITH(codec.images->encode_png(Raster8()), Contains("empty"));
    CHECK_THROWS_WITH(codec.images->encode_png(Raster8(2, 2, 2)), Contains("number of channels"));
    CHECK_THROWS_WITH(codec.images->encode_jpeg(Raster8(2, 2, 4), 90), Contains("number of channels"));
    CHECK_THROWS_WITH(codec.images->encode_jpeg(Raster8(2, 2, 3), 0), Contains("expected 1 to 100"));
    CHECK_THROWS_WITH(codec.images->encode_jpeg(Raster8(2, 2, 3), 101), Contains("expected 1 to 100"));
    CHECK_THROWS_WITH(codec.images->encode_jpeg(Raster8(65'501, 1, 3), 90), Contains("at most 65500"));
}
