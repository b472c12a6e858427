#pragma once

#include "diagnosis.h"

#include <fresco/camera.h>
#include <fresco/image.h>

#include <vector>

namespace fresco::inspect
{

/// One row of the picture.
struct Panel
{
    Raster8 picture;         ///< RGB; empty = none.
    Raster8 outlined;        ///< Of the picture's size, 1 = the mesh's outline.
    RasterF measured;        ///< Meters; empty = none.
    RasterF mesh;            ///< Meters, of the size of `measured`.
    bool suggested = false;  ///< Drawn as a finding has it, not as recorded.
};

inline constexpr int panel_height_px = 240;

/// All panels below each other, RGB: the picture with the outline (red as recorded, green as suggested), measured depth, the
/// mesh's depth (near is light, gray is nothing) and their difference: white within 1 %, red where the mesh is nearer, blue where
/// it is farther, full at 10 %. \pre panels of one recording, at least one
Raster8 draw(const std::vector<Panel>& panels);

}  // namespace fresco::inspect
