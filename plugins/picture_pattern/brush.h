#pragma once

#include "motif.h"

#include <fresco/progress.h>
#include <fresco/raster.h>

#include <cstdint>

namespace pattern
{

struct BrushOptions
{
    int size_px;
    float stroke_share;   ///< Width of the broadest brush as a share of the picture.
    float stroke_length;  ///< Length of a stroke in widths.
    std::uint32_t seed;
};

/// Paints a motif with layers of bristled strokes that follow its direction, broad ones first, and lights the paint from the
/// upper left. After Litwinowicz, "Processing images and video for an impressionist effect" (SIGGRAPH 1997) and Hertzmann,
/// "Painterly rendering with curved brush strokes of multiple sizes" (SIGGRAPH 1998). Square RGB. One thread; throws Canceled.
fresco::Raster<std::uint8_t> paint(const Motif& motif, const BrushOptions& options, fresco::Progress& progress);

}  // namespace pattern
