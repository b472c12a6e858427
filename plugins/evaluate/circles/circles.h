#pragma once

#include <fresco/camera.h>
#include <fresco/evaluation/statistics.h>
#include <fresco/image.h>
#include <fresco/math.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

/// \file Finds red circles in pictures, puts them on the surface and tells whether their size depends on the distance from the
/// camera. The stage runs the steps one after the other, for each picture in parallel.

/// An ellipse in pixel coordinates (centers at +0.5).
struct Ellipse
{
    fresco::Vec2d center;
    fresco::Vec2d half_axis_1;  ///< From the center to the ellipse.
    fresco::Vec2d half_axis_2;  ///< Perpendicular to it.

    double radius_px() const { return (length(half_axis_1) + length(half_axis_2)) / 2; }
    double stretch() const;
};

/// Numbers of contours of a picture's red parts, by outcome.
struct ContourCounts
{
    std::size_t contours = 0;
    std::size_t not_convex = 0;    ///< A convexity defect of more than 2 px, or a contour that touches itself.
    std::size_t no_ellipse = 0;    ///< Fewer than five points, or no finite fit.
    std::size_t out_of_range = 0;  ///< Too small, too large or too stretched.

    ContourCounts& operator+=(const ContourCounts& other);
};

/// 255 where an RGB picture is red: hue in [0, 0.08] or [0.88, 1], saturation and value >= 0.6, and a gray value above 0.15.
fresco::Raster8 red_mask(const fresco::Raster8& rgb);

/// The ellipses of a picture's red parts: mask, fastNlMeansDenoising (strength 100, as released), outer contours,
/// fitEllipse; radius 10..1000 px, stretch <= 10; half a pixel is added to the half axes, because a contour runs through the
/// centers of the outermost pixels. Any thread.
std::vector<Ellipse> find_ellipses(const fresco::Raster8& rgb, ContourCounts& counts);

/// The version of OpenCV; its algorithms decide what is found.
const char* opencv_version();

/// An ellipse and its size on the surface.
struct Circle
{
    Ellipse ellipse;
    double depth = 0;  ///< At the center, meters along the optical axis.
    /// Radius and stretch on the surface; nullopt without surface at the axes' ends.
    struct World
    {
        double radius_m = 0;
        double stretch = 0;
    };
    std::optional<World> world;
};

/// Depth in meters of the surface at pixel coordinates, which may lie outside of the picture; nullopt without surface.
using DepthAt = std::function<std::optional<double>(fresco::Vec2d)>;

/// Puts ellipses on the surface, except those without surface at their center. A half axis is half the distance between the
/// surface points at both ends of the axis or, if only one end has surface, that point's distance from the center's.
std::vector<Circle> circles_on_surface(const std::vector<Ellipse>& ellipses, const fresco::Camera& camera,
                                       const DepthAt& depth_at);

struct CircleStatistics
{
    double corr_2d = 0;  ///< Pearson's correlation of depth and radius in pixels; NaN if undefined.
    double corr_3d = 0;  ///< Correlation of depth and radius in meters.
    double stretch = 0;  ///< Mean stretch on the surface.
};

struct CircleFigures
{
    std::size_t circles = 0;     ///< With a depth at the center.
    std::size_t circles_3d = 0;  ///< With a radius in meters too.
    CircleStatistics value;
    fresco::evaluation::Interval corr_2d;
    fresco::evaluation::Interval corr_3d;
    fresco::evaluation::Interval stretch;
};

/// The statistics of all pictures and their intervals over pictures.
CircleFigures circle_figures(const std::vector<std::vector<Circle>>& pictures, const fresco::evaluation::Bootstrap& bootstrap);
