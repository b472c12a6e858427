#pragma once

#include <fresco/artifact.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file Pictures and grids of values in memory, and the artifact `image`. Picture files are read and written by image_io.h.

namespace fresco
{

/// A picture or a grid of values: H x W x C, row-major, channels interleaved, row 0 at the top. Owns its values.
template <class T>
struct Raster
{
    int width = 0;
    int height = 0;
    int channels = 1;
    std::vector<T> values;

    Raster() = default;
    Raster(int w, int h, int c = 1, T fill = T{})
        : width(w), height(h), channels(c),
          values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c), fill)
    {
    }

    bool empty() const { return values.empty(); }
    std::size_t index(int x, int y, int c = 0) const
    {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                   static_cast<std::size_t>(channels) +
               static_cast<std::size_t>(c);
    }
    const T& at(int x, int y, int c = 0) const { return values[index(x, y, c)]; }
    T& at(int x, int y, int c = 0) { return values[index(x, y, c)]; }
    friend bool operator==(const Raster&, const Raster&) = default;
};

/// Area-averaged when shrinking, bilinear when enlarging; pixel centers at +0.5. Any channel count. Throws std::invalid_argument
/// for an empty source or a target size < 1.
Raster<std::uint8_t> resized(const Raster<std::uint8_t>& source, int width, int height);
Raster<float> resized(const Raster<float>& source, int width, int height);

using Raster8 = Raster<std::uint8_t>;
using Raster16 = Raster<std::uint16_t>;
using RasterF = Raster<float>;

/// An 8-bit sRGB picture: 1 (gray), 3 (RGB) or 4 (RGBA, straight alpha) channels. On disk: `image.packed`, a packed
/// raster (sdk/docs/packed_rasters.md).
struct Image : Artifact
{
    static constexpr std::string_view artifact_name = "image";
    static constexpr int artifact_version = 2;

    Raster8 pixels;

    Image() = default;
    explicit Image(Raster8 p) : pixels(std::move(p)) {}

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Image> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    void write_exchange(const Exchange& to) const override;
    static std::shared_ptr<Image> from_exchange(const Exchange& from);
};

}  // namespace fresco
