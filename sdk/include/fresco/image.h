#pragma once

#include <fresco/artifact.h>
#include <fresco/raster.h>

#include <cstdint>

namespace fresco
{

using Raster8 = Raster<std::uint8_t>;
using Raster16 = Raster<std::uint16_t>;
using RasterF = Raster<float>;

/// An 8-bit sRGB picture: 1 (gray), 3 (RGB) or 4 (RGBA, straight alpha) channels. On disk: `image.npy`, uint8 H x W x C.
struct Image : Artifact
{
    static constexpr std::string_view artifact_name = "image";
    static constexpr int artifact_version = 1;

    Raster8 pixels;

    ~Image() override;
    Image() = default;
    explicit Image(Raster8 p) : pixels(std::move(p)) {}
    Image(const Image&) = default;
    Image(Image&&) = default;
    Image& operator=(const Image&) = default;
    Image& operator=(Image&&) = default;

    void save(const ArtifactFolder& folder) const override;
    static std::shared_ptr<Image> load(const ArtifactFolder& folder);
    static std::vector<ExchangeForm> exchange_forms();
    void write_exchange(const Exchange& to) const override;
    static std::shared_ptr<Image> from_exchange(const Exchange& from);
    /// Itself.
    void preview(Preview& page) const override;
};

}  // namespace fresco
