#include "catch.h"
#include "codec.h"
#include "color_profile.h"

#include <lcms2.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace samples;
using image_opencv::icc_of_primaries;

namespace
{

using Color = std::array<double, 3>;

constexpr std::array<float, 8> display_p3{0.68F, 0.32F, 0.265F, 0.69F, 0.15F, 0.06F, 0.3127F, 0.329F};
constexpr std::array<float, 8> srgb{0.64F, 0.33F, 0.3F, 0.6F, 0.15F, 0.06F, 0.3127F, 0.329F};

double light_of(double v)
{
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double displayed(double light)
{
    light = std::clamp(light, 0.0, 1.0);
    return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// The sRGB value of a Display P3 color, 0..255: the product of the matrices of SMPTE EG 432-1 and IEC 61966-2-1.
Color from_p3(const Color& p3)
{
    const double r = light_of(p3[0] / 255), g = light_of(p3[1] / 255), b = light_of(p3[2] / 255);
    return {255 * displayed(1.2249402 * r - 0.2249402 * g), 255 * displayed(-0.0420570 * r + 1.0420570 * g),
            255 * displayed(-0.0196376 * r - 0.0786361 * g + 1.0982735 * b)};
}

/// Gradients through the gamut, 48 colors; all values odd, so that no format rounds them.
std::vector<std::array<int, 3>> gradient()
{
    std::vector<std::array<int, 3>> colors;
    for (int i = 0; i < 16; ++i)
        for (const auto& color :
             {std::array{1 + 16 * i, 129, 61}, {241, 1 + 16 * i, 255 - 16 * i}, {1 + 16 * i, 1 + 16 * i, 1 + 16 * i}})
            colors.push_back(color);
    return colors;
}

void check_converted(const Raster8& read, int step)
{
    const auto colors = gradient();
    double most = 0;
    for (std::size_t i = 0; i < colors.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
        {
            const auto& [r, g, b] = colors[i];
            const double expected = from_p3({double(r), double(g), double(b)})[c];
            most = std::max(most, std::abs(expected - read.at(step * static_cast<int>(i), 0, static_cast<int>(c))));
        }
    CHECK(most <= 1);
}

Bytes jpeg_piece(int number, int count, std::span<const std::byte> part)
{
    Bytes data;
    put(data, std::string_view("ICC_PROFILE\0", 12));
    put(data, bytes_of({number, count}));
    put(data, part);
    return segment(0xE2, data);
}

/// PNG of the gradient: a row of pixels of `bits`, with alpha 255 - i if requested.
Png gradient_png(int bits, bool with_alpha, const Bytes& icc)
{
    Png png{
        .width = 48, .bits = bits, .color_type = with_alpha ? 6 : 2, .rows = bytes_of({0}), .before_data = profile_chunk(icc)};
    int i = 0;
    for (const auto& color : gradient())
    {
        for (const int v : color)
            put(png.rows, static_cast<std::uint64_t>(bits == 16 ? 257 * v : v), bits / 8);
        if (with_alpha)
            put(png.rows, static_cast<std::uint64_t>(255 - i++), 1);
    }
    return png;
}

Jpeg gradient_jpeg(const Bytes& before_frame)
{
    Jpeg jpeg{.blocks_x = 48, .before_frame = before_frame};
    for (const auto& color : gradient())
        jpeg.blocks.emplace_back(color.begin(), color.end());
    return jpeg;
}

}  // namespace

TEST_CASE_METHOD(WithCodec, "image.opencv: a Display P3 gradient has its known sRGB values in PNG, JPEG and WebP")
{
    const Bytes icc = icc_of_primaries(display_p3, 0, "");
    CHECK(std::abs(from_p3({200, 100, 50})[0] - 200) > 8);  // Else the test shows nothing.
    check_converted(codec.images->read_rgb(codec.write(file_of(gradient_png(8, false, icc)))), 1);
    check_converted(codec.images->read_rgb(codec.write(file_of(gradient_png(16, false, icc)))), 1);
    const Raster8 clear = codec.images->read_with_alpha(codec.write(file_of(gradient_png(8, true, icc))));
    check_converted(clear, 1);
    for (int i = 0; i < 48; ++i)
        CHECK(clear.at(i, 0, 3) == 255 - i);

    // Three pieces, the second of which comes last.
    Bytes before = adobe_segment(0);
    const std::span all(icc);
    put(before, jpeg_piece(1, 3, all.first(100)));
    put(before, jpeg_piece(3, 3, all.subspan(250)));
    put(before, jpeg_piece(2, 3, all.subspan(100, 150)));
    check_converted(codec.images->read_rgb(codec.write(file_of(gradient_jpeg(before)))), 8);

    cv::Mat mat(1, 48, CV_8UC3);
    for (std::size_t i = 0; i < 48; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            mat.ptr<std::uint8_t>()[3 * i + 2 - c] = static_cast<std::uint8_t>(gradient()[i][c]);
    std::vector<std::uint8_t> plain;
    cv::imencode(".webp", mat, plain, {cv::IMWRITE_WEBP_QUALITY, 101});
    const Bytes webp = extended_webp(0x20, 48, 1, riff_chunk("ICCP", icc), to_bytes(plain));
    check_converted(codec.images->read_rgb(codec.write(webp)), 1);
}

TEST_CASE_METHOD(WithCodec, "image.opencv: profiles of sRGB and of CMYK change nothing, those of gray convert grays")
{
    const Bytes icc = icc_of_primaries(display_p3, 0, "");
    Bytes cmyk = icc;
    constexpr std::size_t color_space_at = 16;
    std::ranges::copy(bytes_of({'C', 'M', 'Y', 'K'}), cmyk.begin() + color_space_at);
    for (const Bytes& profile : {icc_of_primaries(srgb, 0, ""), cmyk})
    {
        Png png = gradient_png(8, false, profile);
        const auto with_profile = codec.rgb(file_of(png));
        png.before_data.clear();
        CHECK(codec.rgb(file_of(png)) == with_profile);
    }

    cmsToneCurve* const linear = cmsBuildGamma(nullptr, 1);
    const cmsHPROFILE gray = cmsCreateGrayProfile(cmsD50_xyY(), linear);
    cmsUInt32Number size = 0;
    cmsSaveProfileToMem(gray, nullptr, &size);
    Bytes bytes(size);
    cmsSaveProfileToMem(gray, bytes.data(), &size);
    cmsCloseProfile(gray);
    cmsFreeToneCurve(linear);
    const Png grays{.width = 3, .rows = bytes_of({0, 0, 55, 255}), .before_data = profile_chunk(bytes)};
    const auto values = codec.rgb(file_of(grays));
    CHECK(values[0] == 0);
    CHECK(std::abs(values[4] - 255 * displayed(55 / 255.0)) <= 1);
    CHECK(values[8] == 255);
    // Neutral in P3 is neutral in sRGB, by the same curve.
    CHECK(codec.rgb(file_of(Png{.width = 2, .rows = bytes_of({0, 7, 90}), .before_data = profile_chunk(icc)})) ==
          std::vector<std::uint8_t>{7, 7, 7, 90, 90, 90});
}

TEST_CASE_METHOD(WithCodec, "image.opencv: damaged profiles are refused with the file's name")
{
    const Bytes icc = icc_of_primaries(display_p3, 0, "");
    const auto png = [&](const Bytes& iccp) {
        return file_of(Png{.color_type = 2, .rows = bytes_of({0, 1, 2, 3}), .before_data = chunk("iCCP", iccp)});
    };
    const auto message = [&](const Bytes& file, const char* expected)
    { CHECK_THROWS_WITH(codec.rgb(file), Contains("picture: ") && Contains(expected)); };
    message(png(bytes_of({'p', '3', 0, 1})), "byte 33: the color profile (iCCP) has no name");
    message(png(bytes_of({'p', '3'})), "byte 33: the color profile (iCCP) has no name");
    message(png(bytes_of({'p', '3', 0, 0, 1, 2, 3})), "byte 33: the color profile (iCCP) is damaged");
    message(file_of(gradient_png(8, false, bytes_of({1, 2, 3}))), "its color profile is damaged; convert the picture to sRGB");
    message(file_of(gradient_png(8, false, Bytes((std::size_t{1} << 24U) + 70'000))), "more than 16 MiB");
    message(file_of(gradient_jpeg(jpeg_piece(1, 2, icc))), "piece 2 of 2 of the color profile is missing");
    message(file_of(gradient_jpeg(jpeg_piece(0, 2, icc))), "piece 0 of 2 of a color profile of 2");
    for (std::size_t at = 0; at < icc.size(); at += 3)
    {
        Bytes damaged = icc;
        damaged[at] ^= std::byte{0x55};
        try
        {
            codec.rgb(file_of(gradient_png(8, false, damaged)));
        }
        catch (const Error& error)
        {
            CHECK_THAT(error.what(), Contains("convert the picture to sRGB"));
        }
    }
    CHECK_THROWS_WITH(icc_of_primaries({}, 0, "a.avif"), Contains("a.avif: "));
}
