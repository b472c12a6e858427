#include "circles.h"

#include <algorithm>
#include <cmath>
#include <utility>

using namespace fresco;

namespace
{
/// Where the camera sees the surface at pixel coordinates.
class Surface
{
  public:
    Surface(const Camera& camera, const DepthAt& depth_at) : camera_(camera), depth_at_(depth_at) {}

    std::optional<Vec3d> point(Vec2d pixel) const
    {
        const auto depth = depth_at_(pixel);
        if (!depth)
            return std::nullopt;
        return camera_.world_from_camera.translation + camera_.ray(pixel.x, pixel.y) * *depth;
    }

    /// The center of the pixel, within the picture, that is nearest to `p`.
    Vec2d pixel_center(Vec2d p) const
    {
        return {std::clamp(std::floor(p.x), 0.0, camera_.intrinsics.width - 1.0) + 0.5,
                std::clamp(std::floor(p.y), 0.0, camera_.intrinsics.height - 1.0) + 0.5};
    }

    bool in_picture(Vec2d p) const
    {
        return p.x >= 0 && p.y >= 0 && p.x < camera_.intrinsics.width && p.y < camera_.intrinsics.height;
    }

    std::optional<double> depth(Vec2d pixel) const { return depth_at_(pixel); }

  private:
    const Camera& camera_;
    const DepthAt& depth_at_;
};

std::optional<double> half_length(const Surface& surface, Vec3d center, Vec2d pixel, Vec2d half_axis)
{
    const auto one = surface.point(pixel + half_axis);
    const auto other = surface.point(pixel - half_axis);
    if (one && other)
        return length(*one - *other) / 2;
    if (one || other)
        return length((one ? *one : *other) - center);
    return std::nullopt;
}

std::optional<Circle::World> world_of(double a, double b)
{
    if (a <= 0 || b <= 0)
        return std::nullopt;
    return Circle::World{(a + b) / 2, std::max(a / b, b / a)};
}

std::optional<Circle> circle_of_paper(const Ellipse& ellipse, const Surface& surface)
{
    const auto depth = surface.depth(ellipse.center);
    const auto center = surface.point(ellipse.center);
    if (!depth || !center)
        return std::nullopt;
    Circle circle{ellipse, *depth, std::nullopt};
    const auto a = half_length(surface, *center, ellipse.center, ellipse.half_axis_1);
    const auto b = half_length(surface, *center, ellipse.center, ellipse.half_axis_2);
    if (a && b)
        circle.world = world_of(*a, *b);
    return circle;
}

std::optional<Circle> circle_of_released(const Ellipse& ellipse, const Surface& surface)
{
    Vec2d right = ellipse.half_axis_1;
    Vec2d up = ellipse.half_axis_2;
    if (std::abs(right.x) < std::abs(up.x))
        std::swap(right, up);
    if (right.x < 0)
        right = right * -1;
    if (up.y > 0)
        up = up * -1;
    const auto end = [&](Vec2d half_axis)
    {
        const Vec2d first = ellipse.center + half_axis;
        return surface.pixel_center(surface.in_picture(first) ? first : ellipse.center - half_axis);
    };
    const Vec2d pixel = surface.pixel_center(ellipse.center);
    const auto depth = surface.depth(pixel);
    const auto center = surface.point(pixel);
    const auto horizontal = surface.point(end(right));
    const auto vertical = surface.point(end(up));
    if (!depth || !center || !horizontal || !vertical)
        return std::nullopt;
    return Circle{ellipse, *depth, world_of(length(*horizontal - *center), length(*vertical - *center))};
}
}  // namespace

std::vector<Circle> circles_on_surface(const std::vector<Ellipse>& ellipses, const Camera& camera, const DepthAt& depth_at,
                                       Protocol protocol)
{
    const Surface surface(camera, depth_at);
    std::vector<Circle> circles;
    for (const Ellipse& ellipse : ellipses)
        if (const auto circle =
                protocol == Protocol::paper ? circle_of_paper(ellipse, surface) : circle_of_released(ellipse, surface))
            circles.push_back(*circle);
    return circles;
}
