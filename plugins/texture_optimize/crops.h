#pragma once

#include <fresco/image.h>

#include <vector>

namespace fresco::optimize
{

/// Pixels [x0, x1) x [y0, y1).
struct PixelBox
{
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;
    int y1 = 0;
    std::int64_t area() const { return static_cast<std::int64_t>(x1 - x0) * (y1 - y0); }
    friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

/// A part of a frame that is encoded by itself.
struct Crop
{
    PixelBox core;     ///< Whose features are used.
    PixelBox encoded;  ///< The core and the pixels that its features see.
};

/// Crops whose cores are disjoint and together hold every pixel of `mask`; one of the whole frame where crops would save less
/// than a tenth of its pixels, none for an empty mask. Boxes begin at multiples of `align` and end there or at the frame's
/// border, so that a network whose strides divide `align` gives in a crop's core what it gives in the whole frame. \param
/// margin_px  pixels beyond its own cell that a feature sees
std::vector<Crop> covering_crops(const Raster8& mask, int align, int margin_px);

}  // namespace fresco::optimize
