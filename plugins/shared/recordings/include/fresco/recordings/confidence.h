#pragma once

#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/option.h>
#include <fresco/recordings/recorded_view.h>

#include <filesystem>
#include <string_view>

/// \file Depth of phones, which comes with ARKit's levels of confidence: 0, 1 and 2.

namespace fresco::recordings
{

/// The option `min_confidence`.
Option<int> min_confidence_option(Configurable* owner);

/// Sets depth to 0, none, where its confidence is below `least`. Throws Error naming `source` for pictures of two sizes.
void remove_unsure(Raster16& depth, const Raster8& confidence, int least, std::string_view source);

/// Writes the depth picture of a view anew into `folder`, without what the 8-bit picture `confidence` puts below `least`, and
/// sets its path. False, and nothing is written, where there is no such picture or everything is sure enough.
bool write_sure_depth(RecordedView& view, const std::filesystem::path& confidence, int least, const ImageIo& images,
                      const std::filesystem::path& folder);

}  // namespace fresco::recordings
