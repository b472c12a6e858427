#pragma once

#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/npy.h>

#include <atomic>
#include <vector>

namespace fresco::testing
{

/// A codec for tests that need no picture library: "png" and "jpeg" alike are NPY of height x width, and x channels if several.
class RawImages final : public ImageIo
{
  public:
    int orientation = 1;                  ///< Orientation that check() returns for every picture.
    mutable std::atomic<int> encoded{0};  ///< How many pictures were encoded, …
    mutable std::atomic<int> depths{0};   ///< … and how many depth pictures decoded.

    ImageHeader header(const std::filesystem::path& file) const override
    {
        const ImageHeader all = check(file);
        return {all.width, all.height};
    }
    ImageHeader check(const std::filesystem::path& file) const override
    {
        const NpyArray array = read_npy(file);
        const auto extent = [&](std::size_t axis) { return static_cast<int>(array.shape.at(axis)); };
        return {extent(1),
                extent(0),
                array.type == NpyType::uint8 ? 8 : 16,
                array.shape.size() == 2,
                orientation,
                array.shape.size() == 3 && extent(2) == 4};
    }
    /// Transparent pixels are white.
    Raster8 read_rgb(const std::filesystem::path& file) const override
    {
        const Raster8 image = read_with_alpha(file);
        if (image.channels == 3)
            return image;
        Raster8 rgb(image.width, image.height, 3);
        for (std::size_t i = 0; i < rgb.values.size(); ++i)
            rgb.values[i] = image.values[i / 3 * 4 + 3] < least_opaque_alpha ? 255 : image.values[i / 3 * 4 + i % 3];
        return rgb;
    }
    Raster8 read_with_alpha(const std::filesystem::path& file) const override
    {
        return decode<std::uint8_t>(file, check(file).alpha ? 4 : 3);
    }
    Raster16 read_depth(const std::filesystem::path& file) const override
    {
        ++depths;
        return decode<std::uint16_t>(file, 1);
    }
    std::vector<std::byte> encode_png(const Raster8& image) const override { return encode(image); }
    std::vector<std::byte> encode_png(const Raster16& image) const override { return encode(image); }
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode(image); }

  private:
    template <class T>
    static Raster<T> decode(const std::filesystem::path& file, int channels)
    {
        Raster<T> image = to_raster<T>(read_npy(file), file.string());
        if (image.channels != channels)
            throw Error(file.string() + ": a raw picture of another kind");
        return image;
    }

    template <class T>
    std::vector<std::byte> encode(const Raster<T>& image) const
    {
        ++encoded;
        return to_npy(image);
    }
};

}  // namespace fresco::testing
