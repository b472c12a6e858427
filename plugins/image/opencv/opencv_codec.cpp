#include "opencv_codec.h"

#include <fresco/error.h>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>

namespace image_opencv
{
namespace
{

template <class T>
std::uint8_t on_white(std::uint64_t color, std::uint64_t alpha)
{
    constexpr std::uint64_t white = std::numeric_limits<T>::max();
    // (color alpha + white (white - alpha)) / white is on the scale of T; one rounding takes it to 0..255.
    constexpr std::uint64_t divisor = white * white / 255;
    return static_cast<std::uint8_t>((color * alpha + white * (white - alpha) + divisor / 2) / divisor);
}

}  // namespace

template <class T>
fresco::Raster8 to_rgb(const fresco::Raster<T>& picture, std::optional<std::uint16_t> transparent_gray)
{
    constexpr std::uint64_t opaque = std::numeric_limits<T>::max();
    fresco::Raster8 result(picture.width, picture.height, 3);
    const std::size_t pixels = result.values.size() / 3;
    const auto channels = static_cast<std::size_t>(picture.channels);
    for (std::size_t i = 0; i < pixels; ++i)
    {
        const T* const from = &picture.values[i * channels];
        std::uint64_t alpha = channels == 4 ? from[3] : opaque;
        if (channels == 1 && transparent_gray == from[0])
            alpha = 0;
        for (std::size_t c = 0; c < 3; ++c)
            result.values[i * 3 + c] = on_white<T>(from[channels == 1 ? 0 : c], alpha);
    }
    return result;
}

template fresco::Raster8 to_rgb(const fresco::Raster8&, std::optional<std::uint16_t>);
template fresco::Raster8 to_rgb(const fresco::Raster16&, std::optional<std::uint16_t>);

template <class T>
fresco::Raster8 to_rgba(const fresco::Raster<T>& picture, std::optional<std::uint16_t> transparent_gray)
{
    constexpr unsigned step = std::numeric_limits<T>::max() / 255U;
    const auto in_8_bits = [](T v) { return static_cast<std::uint8_t>((v + step / 2) / step); };
    fresco::Raster8 result(picture.width, picture.height, 4);
    if (picture.channels == 4)
        std::ranges::transform(picture.values, result.values.begin(), in_8_bits);
    else
        for (std::size_t i = 0; i < result.values.size(); ++i)
        {
            const T gray = picture.values[i / 4];
            constexpr std::uint8_t clear = 0, opaque = 255;
            result.values[i] = i % 4 < 3 ? in_8_bits(gray) : gray == transparent_gray ? clear : opaque;
        }
    return result;
}

template fresco::Raster8 to_rgba(const fresco::Raster8&, std::optional<std::uint16_t>);
template fresco::Raster8 to_rgba(const fresco::Raster16&, std::optional<std::uint16_t>);

namespace
{

// Filtered rows of photographs and paintings repeat hardly anything but the byte before: looking for that alone takes half the
// time of zlib's search and gives smaller files. It is the same at any level, but without one OpenCV tries only one filter.
const std::vector<int> png_settings{cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_RLE};
// libjpeg's own limit (JPEG_MAX_DIMENSION); libpng's is far beyond what fits into memory.
constexpr int max_jpeg_side = 65500;

/// The raster's values. OpenCV has no view that cannot be written to.
template <class T>
cv::Mat view_of(const fresco::Raster<T>& raster)
{
    const int type = CV_MAKETYPE(cv::DataType<T>::depth, raster.channels);
    return {raster.height, raster.width, type, const_cast<T*>(raster.values.data())};
}

/// From RGB(A) to OpenCV's BGR(A), or the other way; gray stays as it is. Both have one size and type.
void copy_swapped(const cv::Mat& from, cv::Mat to)
{
    constexpr std::array channels{0, 2, 1, 1, 2, 0, 3, 3};
    if (from.channels() == 1)
        from.copyTo(to);
    else
        cv::mixChannels(&from, 1, &to, 1, channels.data(), static_cast<std::size_t>(from.channels()));
}

template <class T>
fresco::Raster<T> raster_of(const cv::Mat& mat)
{
    fresco::Raster<T> raster(mat.cols, mat.rows, mat.channels());
    copy_swapped(mat, view_of(raster));
    return raster;
}

template <class T>
std::vector<std::byte> encode(const fresco::Raster<T>& image, const char* extension, std::initializer_list<int> channels,
                              const std::vector<int>& parameters)
{
    const auto refuse = [&](const std::string& why)
    {
        throw fresco::Error(fmt::format("a picture of {} x {} x {} cannot be written as {}: {}", image.width, image.height,
                                        image.channels, extension, why));
    };
    if (image.empty() || image.width < 1 || image.height < 1)
        refuse("it is empty");
    if (std::ranges::find(channels, image.channels) == channels.end())
        refuse("the format does not support this number of channels");
    cv::Mat mat(image.height, image.width, CV_MAKETYPE(cv::DataType<T>::depth, image.channels));
    copy_swapped(view_of(image), mat);
    std::vector<unsigned char> encoded;
    bool done = false;
    try
    {
        done = cv::imencode(extension, mat, encoded, parameters);
    }
    catch (const cv::Exception& error)
    {
        refuse(error.what());
    }
    if (!done)
        refuse("the encoder failed; is memory short?");
    std::vector<std::byte> bytes(encoded.size());
    std::memcpy(bytes.data(), encoded.data(), encoded.size());
    return bytes;
}

}  // namespace

fresco::Raster8 oriented(fresco::Raster8 picture, int orientation)
{
    if (orientation == 1)
        return picture;
    // 5 to 8: rows and columns change places. Then rows (4, 8), columns (2, 6) or both (3, 7) are mirrored.
    cv::Mat shown = view_of(picture);
    if (orientation >= 5)
        shown = shown.t();
    fresco::Raster8 result(shown.cols, shown.rows, picture.channels);
    cv::Mat target = view_of(result);
    constexpr std::array codes{0, 0, 1, -1};
    if (orientation == 5)
        shown.copyTo(target);
    else
        cv::flip(shown, target, codes[static_cast<std::size_t>(orientation % 4)]);
    return result;
}

DecodedPicture decode(std::span<const std::byte> bytes, std::string_view source)
{
    const auto fail = [&](const std::string& why)
    { throw fresco::Error(std::string(source) + ": the picture cannot be decoded (" + why + "): it is damaged"); };
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        fail("more than 2 GiB");
    // OpenCV takes no WebP picture of fewer bytes, which those of one color may have.
    constexpr std::size_t least_bytes = 32;
    std::vector<std::byte> padded;
    if (bytes.size() < least_bytes)
    {
        padded.assign(bytes.begin(), bytes.end());
        padded.resize(least_bytes);
        bytes = padded;
    }
    cv::Mat mat;
    try
    {
        // OpenCV reads through a Mat header that cannot be const; it does not write to it.
        const cv::Mat input(1, static_cast<int>(bytes.size()), CV_8UC1,
                            const_cast<void*>(static_cast<const void*>(bytes.data())));
        mat = cv::imdecode(input, cv::IMREAD_UNCHANGED);
    }
    catch (const cv::Exception& error)
    {
        fail(error.what());
    }
    const int channels = mat.channels();
    if (mat.empty() || (channels != 1 && channels != 3 && channels != 4))
        fail(bytes[0] == std::byte{'R'} ? "OpenCV cannot decode it, or was built without WebP" : "OpenCV cannot decode it");
    if (mat.depth() == CV_8U)
        return raster_of<std::uint8_t>(mat);
    if (mat.depth() != CV_16U)
        fail("neither 8 nor 16 bits");
    return raster_of<std::uint16_t>(mat);
}

template <class T>
std::vector<std::byte> encode_png(const fresco::Raster<T>& image)
{
    return encode(image, ".png", {1, 3, 4}, png_settings);
}

template std::vector<std::byte> encode_png(const fresco::Raster8&);
template std::vector<std::byte> encode_png(const fresco::Raster16&);

std::vector<std::byte> encode_jpeg(const fresco::Raster8& image, int quality)
{
    if (quality < 1 || quality > 100)
        throw fresco::Error(fmt::format("JPEG quality {}; expected 1 to 100", quality));
    if (image.width > max_jpeg_side || image.height > max_jpeg_side)
        throw fresco::Error(fmt::format("a JPEG file has at most {} pixels per side; the picture has {}", max_jpeg_side,
                                        std::max(image.width, image.height)));
    return encode(image, ".jpg", {1, 3}, {cv::IMWRITE_JPEG_QUALITY, quality});
}

const char* opencv_version()
{
    return CV_VERSION;
}

}  // namespace image_opencv
