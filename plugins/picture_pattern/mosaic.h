#pragma once

#include "motif.h"

#include <fresco/progress.h>
#include <fresco/raster.h>

#include <cstdint>

namespace pattern
{

/// Lays a motif in small square stones along its direction, with grout between them and a light from the upper left. After
/// Hausner, "Simulating decorative mosaics" (SIGGRAPH 2001), with jittered places in place of his relaxation.
/// \param stones  stones across the picture
/// Square RGB; the same for any thread count. Throws Canceled.
fresco::Raster<std::uint8_t> lay_mosaic(const Motif& motif, int size_px, int stones, std::uint32_t seed,
                                        fresco::Progress& progress);

}  // namespace pattern
