#pragma once

#include "catch.h"
#include "picture_samples.h"

#include <fresco/image_io.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

#include <fstream>

namespace samples
{

/// The built plugin, a folder, and short ways to read what was just written.
class Codec
{
  public:
    std::filesystem::path write(const Bytes& bytes, const std::string& name = "picture")
    {
        // Not write_file: thousands of files that are flushed to the disk would take most of the test's time. A file that is cut
        // to nothing and written again may be flushed too, so it goes first.
        std::filesystem::remove(folder_.path() / name);
        std::ofstream(folder_.path() / name, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return folder_.path() / name;
    }
    std::vector<std::uint8_t> rgb(const Bytes& bytes) { return images->read_rgb(write(bytes)).values; }
    std::filesystem::path folder() const { return folder_.path(); }

    const std::unique_ptr<fresco::ImageIo> images =
        fresco::testing::make_from_plugin<fresco::ImageIo>(FRESCO_PLUGIN_FILE, "image.opencv");

  private:
    fresco::testing::TemporaryFolder folder_;
};

struct WithCodec
{
    Codec codec;
};

/// Checks that the file is refused when it ends after any of its bytes.
inline void refuses_every_beginning(Codec& codec, const Bytes& good)
{
    CHECK_NOTHROW(codec.rgb(good));
    for (std::size_t size = 0; size < good.size(); ++size)
    {
        INFO("the first " << size << " of " << good.size());
        const auto file = codec.write(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
        CHECK_THROWS_AS(codec.images->read_rgb(file), fresco::Error);
        CHECK_THROWS_AS(codec.images->check(file), fresco::Error);
    }
}

/// Values that differ from pixel to pixel.
inline fresco::Raster8 pattern(int width, int height, int channels)
{
    return fresco::testing::noise_picture(width, height, 7, channels);
}

}  // namespace samples
