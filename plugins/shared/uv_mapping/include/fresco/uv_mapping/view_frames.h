#pragma once

#include <fresco/frames.h>
#include <fresco/uv_maps.h>

#include <cstddef>
#include <vector>

namespace fresco
{

/// The frame that each view of the uv maps was made from: its index into `frames`. Throws Error naming the first view whose frame
/// is not there.
std::vector<std::size_t> frames_of_views(const UvMaps& maps, const Frames& frames);

}  // namespace fresco
