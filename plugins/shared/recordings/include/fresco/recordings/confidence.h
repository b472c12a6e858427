#pragma once

#include <fresco/image.h>

#include <string_view>

namespace fresco::recordings
{

/// Sets depth to 0, none, where its confidence (ARKit's levels 0, 1 and 2) is below `least`. Throws Error naming `source` for
/// pictures of two sizes.
void remove_unsure(Raster16& depth, const Raster8& confidence, int least, std::string_view source);

}  // namespace fresco::recordings
