#pragma once

#include "value_space.h"

#include <fresco/image_io.h>
#include <fresco/torch/texture_representation.h>

#include <filesystem>

namespace fresco::optimize
{

/// Writes what the run looks like now into `folder`: `view.png`, the rendered level `view` with its `valid` pixels, and
/// `texture.png`, the whole texture (of size_px) at most 1024 px a side.
void write_preview(const std::filesystem::path& folder, const ImageIo& images, const ValueSpace& space, const TextureView& view,
                   const Raster8& valid, const TextureRepresentation& texture, int size_px);

}  // namespace fresco::optimize
