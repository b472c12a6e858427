#include "artifact_files.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/preview.h>

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

Image::~Image() = default;

void Image::save(const ArtifactFolder& folder) const
{
    detail::write_raster(folder.path / "image.npy", pixels);
}

std::shared_ptr<Image> Image::load(const ArtifactFolder& folder)
{
    return std::make_shared<Image>(detail::read_raster8(folder.path / "image.npy", 0));
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
        save(to.folder);
}

std::shared_ptr<Image> Image::from_exchange(const Exchange& from)
{
    return from.as == png ? std::make_shared<Image>(codec(from).read_rgb(from.folder.path / "image.png")) : load(from.folder);
}

void Image::preview(Preview& page) const
{
    if (!pixels.empty())
        page.picture("", pixels);
}

}  // namespace fresco
