#pragma once

#include "ellipses.h"

#include <fresco/camera.h>

#include <array>
#include <functional>
#include <optional>
#include <vector>

/// An ellipse and what it is on the surface.
struct Circle
{
    Ellipse ellipse;
    double depth = 0;  ///< At the center, meters along the optical axis.
    /// Radius and stretch on the surface; none where it shows nothing at the axes' ends.
    struct World
    {
        double radius_m = 0;
        double stretch = 0;
    };
    std::optional<World> world;
};

/// Depth in meters of what the camera sees at pixel coordinates, which may lie outside of the picture; nothing where it sees no
/// surface.
using DepthAt = std::function<std::optional<double>(fresco::Vec2d)>;

/// Puts ellipses on the surface; those whose center shows none are left out.
/// `paper`: a half axis is half of the distance between the points behind the axis' two ends; where only one end shows the
/// surface, that end's distance from the point behind the center. `released`: everything at whole pixels; one end of each axis,
/// the right and the upper one, or the other one where that is outside of the picture; what has no depth at any of the three is
/// left out.
std::vector<Circle> circles_on_surface(const std::vector<Ellipse>& ellipses, const fresco::Camera& camera,
                                       const DepthAt& depth_at, Protocol protocol);
