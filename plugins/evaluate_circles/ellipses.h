#pragma once

#include <fresco/evaluation/protocol.h>
#include <fresco/image.h>
#include <fresco/math.h>

#include <cstddef>
#include <vector>

using fresco::evaluation::Protocol;

/// In pixel coordinates (centers at +0.5).
struct Ellipse
{
    fresco::Vec2d center;
    fresco::Vec2d half_axis_1;  ///< From the center to the ellipse.
    fresco::Vec2d half_axis_2;  ///< Perpendicular to it.

    double radius_px() const { return (length(half_axis_1) + length(half_axis_2)) / 2; }
    double stretch() const;
};

/// What became of the contours of a picture's red parts.
struct ContourCounts
{
    std::size_t contours = 0;
    std::size_t not_convex = 0;    ///< A convexity defect of more than 2 px, or a contour that touches itself.
    std::size_t no_ellipse = 0;    ///< Fewer than five points, or no finite fit.
    std::size_t out_of_range = 0;  ///< Too small, too large or too stretched.

    ContourCounts& operator+=(const ContourCounts& other);
};

/// 255 where an RGB picture is red. `paper`: hue in [0, 0.08] or [0.88, 1], saturation and value >= 0.6, and a gray value above
/// 0.15. `released`: OpenCV's hue in 0..15 with saturation and value >= 153, or in 160..179 with both >= 102, then Otsu's
/// threshold of the gray values of what is left.
fresco::Raster8 red_mask(const fresco::Raster8& rgb, Protocol protocol);

/// The ellipses of a picture's red parts: mask, fastNlMeansDenoising (strength 100, as released), contours, fitEllipse.
/// `paper`: outer contours; radius 10..1000 px, stretch <= 10; half a pixel is added to the half axes, because a contour runs
/// through the centers of the outermost pixels. `released`: RETR_TREE (the contour of a hole counts too), 10 < w h < 10 000 on
/// the full axes, stretch < 10. Any thread.
std::vector<Ellipse> find_ellipses(const fresco::Raster8& rgb, Protocol protocol, ContourCounts& counts);

/// The version of OpenCV; its algorithms decide what is found.
const char* opencv_version();
