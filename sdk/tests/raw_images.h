#pragma once

#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>

#include <algorithm>
#include <atomic>
#include <vector>

namespace fresco::testing
{

/// A codec for tests that need no picture library: "png" and "jpeg" alike are NPY of height x width, and x channels if several.
class RawImages final : public ImageIo
{
  public:
    int orientation = 1;                  ///< What check() says of every picture.
    mutable std::atomic<int> encoded{0};  ///< How many pictures were encoded.

    ImageHeader header(const std::filesystem::path& file) const override
    {
        const NpyArray array = read_npy(file);
        return {extent(array, 1), extent(array, 0)};
    }
    ImageHeader check(const std::filesystem::path& file) const override
    {
        const NpyArray array = read_npy(file);
        const int bits = array.type == NpyType::uint8 ? 8 : 16;
        return {extent(array, 1), extent(array, 0), bits, channels_of(array) == 1, orientation};
    }
    Raster8 read_rgb(const std::filesystem::path& file) const override { return decode<std::uint8_t>(file, 3); }
    Raster16 read_depth(const std::filesystem::path& file) const override { return decode<std::uint16_t>(file, 1); }
    std::vector<std::byte> encode_png(const Raster8& image) const override { return encode(image, NpyType::uint8); }
    std::vector<std::byte> encode_png(const Raster16& image) const override { return encode(image, NpyType::uint16); }
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode(image, NpyType::uint8); }

  private:
    static int extent(const NpyArray& array, std::size_t axis) { return static_cast<int>(array.shape.at(axis)); }
    static int channels_of(const NpyArray& array) { return array.shape.size() < 3 ? 1 : extent(array, 2); }

    template <class T>
    static Raster<T> decode(const std::filesystem::path& file, int channels)
    {
        const NpyArray array = read_npy(file);
        if (channels_of(array) != channels)
            throw Error(file.string() + ": a raw picture of another kind");
        Raster<T> image(extent(array, 1), extent(array, 0), channels);
        std::ranges::copy(array.as<T>(), image.values.begin());
        return image;
    }

    template <class T>
    std::vector<std::byte> encode(const Raster<T>& image, NpyType type) const
    {
        ++encoded;
        std::vector<std::size_t> shape{static_cast<std::size_t>(image.height), static_cast<std::size_t>(image.width)};
        if (image.channels > 1)
            shape.push_back(static_cast<std::size_t>(image.channels));
        return to_npy(type, shape, std::as_bytes(std::span(image.values)));
    }
};

}  // namespace fresco::testing
