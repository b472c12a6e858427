#pragma once

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>

#include <cstring>

namespace fresco::testing
{

/// A codec for tests that need no picture library: "png" and "jpeg" alike are a small header and the values as they are.
class RawImages final : public ImageIo
{
  public:
    int orientation = 1;  ///< What check() says of every picture.

    ImageHeader header(const std::filesystem::path& file) const override
    {
        const auto h = read(file).first;
        return {h.width, h.height};
    }
    ImageHeader check(const std::filesystem::path& file) const override
    {
        const auto [h, bytes] = read(file);
        const auto values = static_cast<std::size_t>(h.width) * static_cast<std::size_t>(h.height) *
                            static_cast<std::size_t>(h.channels) * static_cast<std::size_t>(h.value_bytes);
        if (bytes.size() != sizeof h + values)
            throw Error(file.string() + ": cut");
        return {h.width, h.height, 8 * h.value_bytes, h.channels == 1, orientation};
    }
    Raster8 read_rgb(const std::filesystem::path& file) const override { return decode<std::uint8_t>(file, 3); }
    Raster16 read_depth(const std::filesystem::path& file) const override { return decode<std::uint16_t>(file, 1); }
    std::vector<std::byte> encode_png(const Raster8& image) const override { return encode(image); }
    std::vector<std::byte> encode_png(const Raster16& image) const override { return encode(image); }
    std::vector<std::byte> encode_jpeg(const Raster8& image, int) const override { return encode(image); }

  private:
    struct Head
    {
        std::array<char, 4> magic{'R', 'A', 'W', 'I'};
        int width = 0;
        int height = 0;
        int channels = 0;
        int value_bytes = 0;
    };

    static std::pair<Head, std::vector<std::byte>> read(const std::filesystem::path& file)
    {
        auto bytes = read_file(file);
        Head head;
        if (bytes.size() < sizeof head)
            throw Error(file.string() + ": not a raw picture");
        std::memcpy(&head, bytes.data(), sizeof head);
        if (head.magic != Head{}.magic)
            throw Error(file.string() + ": not a raw picture");
        return {head, std::move(bytes)};
    }

    template <class T>
    static Raster<T> decode(const std::filesystem::path& file, int channels)
    {
        const auto [head, bytes] = read(file);
        Raster<T> image(head.width, head.height, channels);
        if (head.channels != channels || head.value_bytes != int{sizeof(T)} ||
            bytes.size() != sizeof head + image.values.size() * sizeof(T))
            throw Error(file.string() + ": a raw picture of another kind");
        std::memcpy(image.values.data(), bytes.data() + sizeof head, bytes.size() - sizeof head);
        return image;
    }

    template <class T>
    static std::vector<std::byte> encode(const Raster<T>& image)
    {
        Head head;
        head.width = image.width;
        head.height = image.height;
        head.channels = image.channels;
        head.value_bytes = int{sizeof(T)};
        std::vector<std::byte> bytes(sizeof head + image.values.size() * sizeof(T));
        std::memcpy(bytes.data(), &head, sizeof head);
        std::memcpy(bytes.data() + sizeof head, image.values.data(), bytes.size() - sizeof head);
        return bytes;
    }
};

}  // namespace fresco::testing
