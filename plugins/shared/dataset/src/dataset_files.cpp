#include <fresco/dataset/dataset_files.h>

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/npy.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace fresco::dataset
{
namespace
{

constexpr std::size_t max_pixels = 200'000'000;
constexpr double steps = 65535;
constexpr float uv_rounding = 1e-5F;

[[noreturn]] void fail(std::string_view source, const std::string& what)
{
    throw Error(std::string(source) + ": " + what);
}

std::string text_of(const std::vector<std::size_t>& shape)
{
    return fmt::format("{}", fmt::join(shape, " x "));
}

std::string pixel_text(std::size_t pixel, int width)
{
    const auto columns = static_cast<std::size_t>(width);
    return fmt::format("pixel ({}, {})", pixel % columns, pixel / columns);
}

/// Throws Error for the first pixel whose values are not `good`.
template <class T, class Good>
void check_values(const Raster<T>& raster, std::string_view source, const char* expected, const Good& good)
{
    const auto bad = std::ranges::find_if_not(raster.values, good);
    if (bad == raster.values.end())
        return;
    const auto at = static_cast<std::size_t>(bad - raster.values.begin()) / static_cast<std::size_t>(raster.channels);
    fail(source, fmt::format("{} holds {:.5g}; expected {}", pixel_text(at, raster.width), static_cast<double>(*bad), expected));
}

}  // namespace

FileStamp write_stamped(const std::filesystem::path& file, std::span<const std::byte> bytes)
{
    write_file(file, bytes);
    return {bytes.size(), content_hash(bytes)};
}

std::vector<std::byte> read_stamped(const std::filesystem::path& file, const FileStamp& stamp)
{
    const std::string way_out = "; copy the dataset again from where it was written";
    if (!std::filesystem::exists(file))
        throw MissingInput(file.string() + ": file is missing" + way_out);
    auto bytes = read_file(file, std::numeric_limits<std::size_t>::max());
    if (bytes.size() != stamp.bytes)
        fail(file.string(), fmt::format("has {} bytes; dataset.json lists {}{}", bytes.size(), stamp.bytes, way_out));
    if (content_hash(bytes) != stamp.hash)
        fail(file.string(), "its contents differ from dataset.json: the file was changed or damaged" + way_out);
    return bytes;
}

template <class T>
Raster<T> raster_from(std::span<const std::byte> npy, int width, int height, int channels, std::string_view source)
{
    const NpyArray array = parse_npy(npy, source);
    std::vector<std::size_t> shape{static_cast<std::size_t>(height), static_cast<std::size_t>(width)};
    if (channels != 1)
        shape.push_back(static_cast<std::size_t>(channels));
    if (array.shape != shape)
        fail(source, "an array of " + text_of(array.shape) + "; expected " + text_of(shape));
    return to_raster<T>(array, source);
}

template Raster8 raster_from(std::span<const std::byte> npy, int width, int height, int channels, std::string_view source);
template Raster16 raster_from(std::span<const std::byte> npy, int width, int height, int channels, std::string_view source);
template RasterF raster_from(std::span<const std::byte> npy, int width, int height, int channels, std::string_view source);

Raster8 picture_from(std::span<const std::byte> npy, std::string_view source)
{
    const NpyArray array = parse_npy(npy, source);
    const auto& shape = array.shape;
    const std::size_t channels = shape.size() == 3 ? shape[2] : 1;
    if (array.type != NpyType::uint8 || (shape.size() != 2 && shape.size() != 3) ||
        (channels != 1 && channels != 3 && channels != 4))
        fail(source, "expected a picture, uint8 of height x width x 3 (or 1, or 4)");
    if (shape[0] == 0 || shape[1] == 0 || shape[0] > max_pixels / shape[1])
        fail(source, "a picture of " + text_of(shape) + "; expected 1 to 200 million pixels");
    return to_raster<std::uint8_t>(array, source);
}

Raster16 quantized(const RasterF& uv)
{
    Raster16 result(uv.width, uv.height, uv.channels);
    // In double: a product rounded to float first could be rounded to another step.
    std::ranges::transform(uv.values, result.values.begin(),
                           [](float u)
                           { return static_cast<std::uint16_t>(std::lround(std::clamp(double{u}, 0.0, 1.0) * steps)); });
    return result;
}

RasterF restored(const Raster16& uv)
{
    RasterF result(uv.width, uv.height, uv.channels);
    std::ranges::transform(uv.values, result.values.begin(), [](std::uint16_t step) { return static_cast<float>(step / steps); });
    return result;
}

void check_valid(const Raster8& valid, std::int64_t ones, std::string_view source)
{
    check_values(valid, source, "0 or 1", [](std::uint8_t v) { return v <= 1; });
    const auto found = std::ranges::count(valid.values, std::uint8_t{1});
    if (found != ones)
        fail(source, fmt::format("{} valid pixels; expected {}", found, ones));
}

void check_uv(const RasterF& uv, std::string_view source)
{
    check_values(uv, source, "a number from 0 to 1", [](float u) { return u >= -uv_rounding && u <= 1 + uv_rounding; });
}

void check_cosine(const RasterF& cosine, std::string_view source)
{
    check_values(cosine, source, "a number from 0 to 1", [](float c) { return c >= 0 && c <= 1; });
}

void check_depth(const RasterF& depth, const Raster8& valid, std::string_view source)
{
    check_values(depth, source, "a distance", [](float d) { return d >= 0 && std::isfinite(d); });
    for (std::size_t i = 0; i < depth.values.size(); ++i)
        if (valid.values[i] != 0 && depth.values[i] <= 0)
            fail(source, pixel_text(i, depth.width) + " is valid and has no depth");
}

}  // namespace fresco::dataset
