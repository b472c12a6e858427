#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fresco
{
namespace
{

constexpr const char* png = "png";

const ImageIo& codec(const Exchange& exchange)
{
    if (exchange.images == nullptr)
        throw Error("no picture codec for 'as: png'; set the option images");
    return *exchange.images;
}

}  // namespace

void Image::save(const ArtifactFolder& folder) const
{
    detail::write_packed(folder.path, "image", pixels);
}

std::shared_ptr<Image> Image::load(const ArtifactFolder& folder)
{
    return std::make_shared<Image>(detail::read_npy_or_packed<std::uint8_t>(folder.path, "image", 0));
}

std::vector<ExchangeForm> Image::exchange_forms()
{
    const ExchangeForm npy{
        .as = "npy", .files = {"image.npy"}, .is_folder = false, .taken_in_place = false, .made_in_place = false};
    ExchangeForm other = npy;
    other.as = png;
    other.files = {"image.png"};
    return {npy, other};
}

void Image::write_exchange(const Exchange& to) const
{
    if (to.as == png)
        write_file(to.folder.path / "image.png", codec(to).encode_png(pixels));
    else
        write_npy(to.folder.path / "image.npy", pixels);
}

std::shared_ptr<Image> Image::from_exchange(const Exchange& from)
{
    return from.as == png ? std::make_shared<Image>(read_picture(codec(from), from.folder.path / "image.png"))
                          : load(from.folder);
}

namespace
{

/// The source pixels that one target pixel averages, with weights that sum to 1.
struct Tap
{
    int first = 0;
    std::vector<float> weights;
};

/// The average by value(i) of the pixels of a tap.
template <class Value>
float average(const Tap& tap, const Value& value)
{
    float sum = 0;
    for (std::size_t k = 0; k < tap.weights.size(); ++k)
        sum += tap.weights[k] * value(tap.first + static_cast<int>(k));
    return sum;
}

/// One axis: box overlap when shrinking, linear interpolation between centers when enlarging.
std::vector<Tap> taps(int from, int to)
{
    std::vector<Tap> result(static_cast<std::size_t>(to));
    const double scale = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i)
    {
        Tap& tap = result[static_cast<std::size_t>(i)];
        if (scale <= 1)
        {
            const double center = (i + 0.5) * scale - 0.5;
            const int left = std::clamp(static_cast<int>(std::floor(center)), 0, from - 1);
            const int right = std::min(left + 1, from - 1);
            const auto share = static_cast<float>(std::clamp(center - left, 0.0, 1.0));
            tap.first = left;
            tap.weights = right == left ? std::vector<float>{1.0F} : std::vector<float>{1 - share, share};
            continue;
        }
        const double begin = i * scale;
        const double end = std::min(static_cast<double>(from), (i + 1) * scale);
        tap.first = static_cast<int>(begin);
        const int last = std::min(from, static_cast<int>(std::ceil(end)));
        for (int j = tap.first; j < last; ++j)
            tap.weights.push_back(
                static_cast<float>((std::min(end, j + 1.0) - std::max(begin, static_cast<double>(j))) / (end - begin)));
    }
    return result;
}

template <class T>
T stored(float value)
{
    if constexpr (std::is_same_v<T, std::uint8_t>)
        return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
    else
        return value;
}

template <class T>
Raster<T> resized_by_axes(const Raster<T>& source, int width, int height)
{
    if (source.empty() || width < 1 || height < 1)
        throw std::invalid_argument("resized: empty picture or target size below 1");
    if (width == source.width && height == source.height)
        return source;
    const auto columns = taps(source.width, width);
    const auto rows = taps(source.height, height);
    Raster<float> narrow(width, source.height, source.channels);
    for (int y = 0; y < source.height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < source.channels; ++c)
                narrow.at(x, y, c) =
                    average(columns[static_cast<std::size_t>(x)], [&](int i) { return static_cast<float>(source.at(i, y, c)); });
    Raster<T> result(width, height, source.channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < source.channels; ++c)
                result.at(x, y, c) =
                    stored<T>(average(rows[static_cast<std::size_t>(y)], [&](int i) { return narrow.at(x, i, c); }));
    return result;
}

}  // namespace

Raster<std::uint8_t> resized(const Raster<std::uint8_t>& source, int width, int height)
{
    return resized_by_axes(source, width, height);
}

Raster<float> resized(const Raster<float>& source, int width, int height)
{
    return resized_by_axes(source, width, height);
}

}  // namespace fresco
