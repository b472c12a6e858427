#pragma once

#include <fresco/dataset/dataset_files.h>
#include <fresco/error.h>
#include <fresco/image_io.h>

#include <atomic>

/// "Pictures" that are NPY inside, so that tests need no codec and see every pixel. Counts what it encodes.
struct NpyCodec final : fresco::ImageIo
{
    mutable std::atomic<int> encoded{0};

    fresco::ImageHeader header(const std::filesystem::path&) const override { throw fresco::Error("not used"); }
    fresco::Raster8 read_rgb(const std::filesystem::path&) const override { throw fresco::Error("not used"); }
    fresco::Raster16 read_depth(const std::filesystem::path&) const override { throw fresco::Error("not used"); }
    std::vector<std::byte> encode_png(const fresco::Raster8& image) const override { return made(image); }
    std::vector<std::byte> encode_png(const fresco::Raster16& image) const override { return made(image); }
    std::vector<std::byte> encode_jpeg(const fresco::Raster8&, int) const override { throw fresco::Error("not used"); }

  private:
    template <class R>
    std::vector<std::byte> made(const R& image) const
    {
        ++encoded;
        return fresco::dataset::to_npy(image);
    }
};
