#include "artifact_files.h"

#include <fresco/image.h>
#include <fresco/preview.h>

namespace fresco
{

Image::~Image() = default;

void Image::save(const ArtifactFolder& folder) const
{
    detail::write_raster(folder.path / "image.npy", pixels);
}

std::shared_ptr<Image> Image::load(const ArtifactFolder& folder)
{
    return std::make_shared<Image>(detail::read_raster8(folder.path / "image.npy", 0));
}

void Image::preview(Preview& page) const
{
    if (!pixels.empty())
        page.picture("", pixels);
}

}  // namespace fresco
