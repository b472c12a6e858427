#include <fresco/recordings/lens.h>

#include <fresco/error.h>
#include <fresco/numerics/bilinear.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace fresco::recordings
{
namespace
{

constexpr double smallest_zoom = 0.5;
constexpr double greatest_zoom = 4;
/// Farther from the middle, a picture without a fisheye's distortion has ever fewer details on ever more pixels: tan 50°.
constexpr double widest_slope = 1.19175;
constexpr int samples_per_side = 64;

double radial_factor(const Lens& lens, double r2)
{
    if (lens.is_fisheye)
    {
        const double r = std::sqrt(r2), angle = std::atan(r), a2 = angle * angle;
        const double bent = 1 + a2 * (lens.k1 + a2 * (lens.k2 + a2 * (lens.k3 + a2 * lens.k4)));
        return r > 0 ? bent * angle / r : 1;
    }
    const double above = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
    const double below = 1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6));
    return above / below;
}

/// Whether radii keep their order out to `radius`.
bool keeps_order(const Lens& lens, double radius)
{
    constexpr int steps = 256;
    double last = 0;
    for (int i = 1; i <= steps; ++i)
    {
        const double r = radius * i / steps;
        const double next = r * radial_factor(lens, r * r);
        if (!(next > last))
            return false;
        last = next;
    }
    return true;
}

Vec2d pinhole_point(const Intrinsics& camera, double x, double y)
{
    return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy};
}

/// Position in the picture of the camera with the lens of what `pinhole` sees at (x, y).
Vec2d source_position(const Intrinsics& camera, const Lens& lens, const Intrinsics& pinhole, double x, double y)
{
    const Vec2d p = lens.distorted(pinhole_point(pinhole, x, y));
    return {camera.fx * p.x + camera.cx, camera.fy * p.y + camera.cy};
}

Intrinsics zoomed(const Intrinsics& camera, double zoom)
{
    Intrinsics result = camera;
    result.fx *= zoom;
    result.fy *= zoom;
    return result;
}

bool sees_nothing_else(const Intrinsics& pinhole, const Intrinsics& camera, const Lens& lens)
{
    const double width = camera.width, height = camera.height;
    double radius = 0;
    for (const double x : {0.0, width})
        for (const double y : {0.0, height})
            radius = std::max(radius, length(pinhole_point(pinhole, x, y)));
    if (!keeps_order(lens, radius))
        return false;
    const auto inside = [&](double x, double y)
    {
        const Vec2d p = source_position(camera, lens, pinhole, x, y);
        return p.x >= 0 && p.y >= 0 && p.x <= width && p.y <= height;
    };
    for (int i = 0; i <= samples_per_side; ++i)
    {
        const double x = width * i / samples_per_side, y = height * i / samples_per_side;
        if (!inside(x, 0) || !inside(x, height) || !inside(0, y) || !inside(width, y))
            return false;
    }
    return true;
}

}  // namespace

Vec2d Lens::distorted(Vec2d p) const
{
    const double r2 = dot(p, p);
    const double radial = radial_factor(*this, r2);
    return {p.x * radial + 2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x),
            p.y * radial + p1 * (r2 + 2 * p.y * p.y) + 2 * p2 * p.x * p.y};
}

Intrinsics pinhole_without(const Lens& lens, const Intrinsics& camera, std::string_view source)
{
    if (!lens.distorts())
        return camera;
    if (!sees_nothing_else(zoomed(camera, greatest_zoom), camera, lens))
        throw Error(
            std::string(source) +
            ": the lens' coefficients fold the picture or displace it by more than its size; expected those of OpenCV's model "
            "(k1, k2, p1, p2, k3, …) for this camera: recalibrate, or undistort the pictures with the recorder's own tool");
    double low = smallest_zoom, high = greatest_zoom;
    if (lens.is_fisheye)
        low = std::max(low, std::max(camera.width / camera.fx, camera.height / camera.fy) / 2 / widest_slope);
    if (sees_nothing_else(zoomed(camera, low), camera, lens))
        return zoomed(camera, low);
    for (int step = 0; step < 40; ++step)
    {
        const double middle = (low + high) / 2;
        (sees_nothing_else(zoomed(camera, middle), camera, lens) ? high : low) = middle;
    }
    return zoomed(camera, high);
}

Raster8 undistorted(const Raster8& picture, const Intrinsics& camera, const Lens& lens, const Intrinsics& pinhole)
{
    const Intrinsics from = camera.scaled_to(picture.width, picture.height);
    const Intrinsics to = pinhole.scaled_to(picture.width, picture.height);
    Raster8 result(picture.width, picture.height, picture.channels);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
        {
            const Vec2d at = source_position(from, lens, to, x + 0.5, y + 0.5);
            const auto column = numerics::between<double>(at.x - 0.5, picture.width);
            const auto row = numerics::between<double>(at.y - 0.5, picture.height);
            for (int c = 0; c < picture.channels; ++c)
            {
                const double value = numerics::bilinear(column, row, [&](int u, int v) { return picture.at(u, v, c); });
                result.at(x, y, c) = static_cast<std::uint8_t>(value + 0.5);
            }
        }
    return result;
}

Raster16 undistorted_depth(const Raster16& depth, const Intrinsics& camera, const Lens& lens, const Intrinsics& pinhole)
{
    const Intrinsics from = camera.scaled_to(depth.width, depth.height);
    const Intrinsics to = pinhole.scaled_to(depth.width, depth.height);
    Raster16 result(depth.width, depth.height);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
        {
            const Vec2d at = source_position(from, lens, to, x + 0.5, y + 0.5);
            const double column = std::floor(at.x), row = std::floor(at.y);
            if (column >= 0 && row >= 0 && column < depth.width && row < depth.height)
                result.at(x, y) = depth.at(static_cast<int>(column), static_cast<int>(row));
        }
    return result;
}

}  // namespace fresco::recordings
