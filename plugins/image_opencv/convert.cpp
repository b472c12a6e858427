#include "convert.h"

#include <algorithm>
#include <limits>
#include <utility>

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

template <class T>
fresco::Raster8 to_rgb_of(const fresco::Raster<T>& picture, std::optional<std::uint16_t> transparent_gray)
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

}  // namespace

fresco::Raster8 to_rgb(const fresco::Raster8& picture, std::optional<std::uint16_t> transparent_gray)
{
    return to_rgb_of(picture, transparent_gray);
}

fresco::Raster8 to_rgb(const fresco::Raster16& picture, std::optional<std::uint16_t> transparent_gray)
{
    return to_rgb_of(picture, transparent_gray);
}

fresco::Raster8 to_rgba(const fresco::Raster8& picture)
{
    return picture;
}

fresco::Raster8 to_rgba(const fresco::Raster16& picture)
{
    fresco::Raster8 result(picture.width, picture.height, picture.channels);
    std::transform(picture.values.begin(), picture.values.end(), result.values.begin(),
                   [](std::uint16_t v) { return static_cast<std::uint8_t>((v + 128U) / 257U); });
    return result;
}

fresco::Raster8 oriented(fresco::Raster8 picture, int orientation)
{
    if (orientation == 1)
        return picture;
    // Orientation 5 to 8: rows and columns change places; then each axis may be mirrored.
    const bool swaps = orientation >= 5;
    const bool mirrors_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool mirrors_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    fresco::Raster8 result(swaps ? picture.height : picture.width, swaps ? picture.width : picture.height, picture.channels);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
        {
            const int from_x = swaps ? y : x;
            const int from_y = swaps ? x : y;
            const auto from =
                picture.index(mirrors_x ? picture.width - 1 - from_x : from_x, mirrors_y ? picture.height - 1 - from_y : from_y);
            const auto to = result.index(x, y);
            for (std::size_t c = 0; c < static_cast<std::size_t>(picture.channels); ++c)
                result.values[to + c] = picture.values[from + c];
        }
    return result;
}

}  // namespace image_opencv
