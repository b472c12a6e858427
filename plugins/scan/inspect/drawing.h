#pragma once

#include <fresco/image.h>

#include <vector>

/// \file Draws the stage's picture: mesh and frames side by side, so that people can check a finding.

namespace fresco::inspect
{

/// One row of the picture; all rasters are panel_height_px high.
struct Panel
{
    Raster8 picture;         ///< RGB; empty = none.
    Raster8 outlined;        ///< Mask of the picture's size, 1 = the mesh's outline.
    RasterF measured;        ///< Meters; empty = none.
    RasterF mesh;            ///< Meters, of the size of `measured`.
    bool suggested = false;  ///< Drawn with the mistakes corrected.
};

inline constexpr int panel_height_px = 240;

/// One row per panel, RGB: the picture with the outline (red as recorded, green as suggested), the measured depth, the mesh's
/// depth (near is light, missing is gray) and their difference: white within 1 %, red where the mesh is nearer, blue where it is
/// farther, full color at 10 %. \pre panels of one recording, at least one
Raster8 draw(const std::vector<Panel>& panels);

}  // namespace fresco::inspect
