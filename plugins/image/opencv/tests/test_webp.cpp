#include "catch.h"
#include "codec.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

using namespace fresco;
using namespace samples;

namespace
{

/// By OpenCV; a quality above 100 loses nothing.
Bytes webp_of(const Raster8& image, int quality = 101)
{
    cv::Mat mat(image.height, image.width, CV_8UC(image.channels));
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < image.channels; ++c)
                mat.ptr<std::uint8_t>(y)[x * image.channels + (c < 3 ? 2 - c : c)] = image.at(x, y, c);
    std::vector<std::uint8_t> encoded;
    cv::imencode(".webp", mat, encoded, {cv::IMWRITE_WEBP_QUALITY, quality});
    return to_bytes(encoded);
}

}  // namespace

TEST_CASE_METHOD(WithCodec, "image.opencv: WebP has the pixels of the PNG, with and without alpha, turned as EXIF says")
{
    const Raster8 colors = pattern(7, 5, 3);
    CHECK(codec.rgb(webp_of(colors)) == colors.values);
    const Raster8 clear = pattern(7, 5, 4);
    CHECK(codec.images->read_with_alpha(codec.write(webp_of(clear))).values == clear.values);
    CHECK(codec.rgb(webp_of(clear)) == codec.rgb(codec.images->encode_png(clear)));
    CHECK(codec.images->check(codec.write(webp_of(clear))).alpha);
    CHECK_FALSE(codec.images->check(codec.write(webp_of(colors))).alpha);
    CHECK(codec.images->check(codec.write(extended_webp(0x10, 7, 5, {}, webp_of(clear)))).alpha);
    // This picture of 100 x 100 transparent pixels has fewer bytes than OpenCV takes.
    const auto tiny = codec.images->read_with_alpha(
        codec.write(riff(riff_chunk("VP8L", bytes_of({0x2F, 0x63, 0xC0, 0x18, 0x10, 0x88, 0x88, 0x08})))));
    CHECK(tiny == Raster8(100, 100, 4, 0));
    for (const bool with_mark : {false, true})
    {
        Bytes exif = with_mark ? bytes_of({'E', 'x', 'i', 'f', 0, 0}) : Bytes{};
        put(exif, tiff_orientation(6, true));
        const auto file = codec.write(extended_webp(0x08, 7, 5, {}, webp_of(colors), riff_chunk("EXIF", exif)));
        const Raster8 turned = codec.images->read_rgb(file);
        CHECK(turned.width == 5);
        // The stored left end is shown at the top.
        CHECK(turned.at(4, 0, 1) == colors.at(0, 0, 1));
        CHECK(turned.at(0, 6, 2) == colors.at(6, 4, 2));
        CHECK(codec.images->check(file).orientation == 6);
    }
}

TEST_CASE_METHOD(WithCodec, "image.opencv: WebP that is cut, damaged, moving or too large is refused")
{
    const Raster8 image = pattern(7, 5, 3);
    for (const Bytes& good : {webp_of(image), webp_of(image, 80), extended_webp(0, 7, 5, {}, webp_of(image))})
    {
        const auto header = codec.images->header(codec.write(good));
        CHECK((header.width == 7 && header.height == 5));
        refuses_every_beginning(codec, good);
    }
    const auto refused = [&](const Bytes& file, const char* why) { CHECK_THROWS_WITH(codec.rgb(file), Contains(why)); };
    refused(extended_webp(0x02, 7, 5, {}, webp_of(image)), "byte 20: a moving WebP");
    refused(extended_webp(0, 8, 5, {}, webp_of(image)), "cannot be decoded");
    refused(extended_webp(0, 60'000, 60'000, {}, webp_of(image)), "at most 300 megapixels");
    refused(riff(riff_chunk("ALPH", Bytes(10))), "byte 12: expected a VP8");
    refused(riff(riff_chunk("VP8L", Bytes(10))), "byte 20: expected the signature of VP8L");
    refused(riff(riff_chunk("VP8 ", Bytes(10))), "byte 23: expected the start of a VP8 key frame");
    Bytes empty = riff_chunk("VP8X", bytes_of({0, 0, 0, 0, 6, 0, 0, 4, 0, 0}));
    refused(riff(empty), "no data (VP8 or VP8L chunk)");
    Bytes overlong = webp_of(image);
    overlong[16] = std::byte{0xFF};
    refused(overlong, "byte 12: a chunk of");
}
