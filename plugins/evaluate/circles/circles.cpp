#include "circles.h"

#include <fresco/images/lab.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

using namespace fresco;

namespace
{

constexpr double max_defect_px = 2;
constexpr float denoising_strength = 100;

cv::Mat view_of(const Raster8& picture)
{
    // OpenCV has no read-only view: the matrix is not written to.
    return {picture.height, picture.width, picture.channels == 3 ? CV_8UC3 : CV_8UC1,
            const_cast<std::uint8_t*>(picture.values.data())};
}

bool is_red(const std::uint8_t* rgb)
{
    const int most = std::max({rgb[0], rgb[1], rgb[2]});
    const int span = most - std::min({rgb[0], rgb[1], rgb[2]});
    // Saturation span / most and value most / 255, both >= 0.6.
    if (most < 153 || span * 5 < most * 3 || rgb[0] != most)
        return false;
    const double hue = static_cast<double>(rgb[1] - rgb[2]) / span / 6;  // of a full turn, negative toward blue
    if (hue > 0.08 || hue < 0.88 - 1)
        return false;
    return fresco::luma(rgb) > 0.15 * 255;
}

/// Returns nothing if the contour is too ragged to have a hull of ordered points.
std::optional<double> largest_defect(const std::vector<cv::Point>& contour)
{
    std::vector<int> hull;
    cv::convexHull(contour, hull);
    if (hull.size() < 3)
        return 0;
    std::vector<cv::Vec4i> defects;
    try
    {
        cv::convexityDefects(contour, hull, defects);
    }
    catch (const cv::Exception&)
    {
        return std::nullopt;
    }
    int largest = 0;
    for (const cv::Vec4i& defect : defects)
        largest = std::max(largest, defect[3]);
    return largest / 256.0;  // OpenCV's fixed point
}

std::optional<Ellipse> fitted(const std::vector<cv::Point>& contour, double added_px)
{
    if (contour.size() < 5)
        return std::nullopt;
    const cv::RotatedRect box = cv::fitEllipse(contour);
    const double half_width = double{box.size.width} / 2;
    const double half_height = double{box.size.height} / 2;
    if (!std::isfinite(half_width * half_height * double{box.center.x} * double{box.center.y}) || half_width <= 0 ||
        half_height <= 0)
        return std::nullopt;
    const double angle = double{box.angle} * std::numbers::pi / 180;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Ellipse{{double{box.center.x} + 0.5, double{box.center.y} + 0.5},
                   Vec2d{c, s} * (half_width + added_px),
                   Vec2d{-s, c} * (half_height + added_px)};
}

bool in_range(const Ellipse& ellipse)
{
    return ellipse.radius_px() >= 10 && ellipse.radius_px() <= 1000 && ellipse.stretch() <= 10;
}

}  // namespace

double Ellipse::stretch() const
{
    const double a = length(half_axis_1);
    const double b = length(half_axis_2);
    return std::max(a / b, b / a);
}

ContourCounts& ContourCounts::operator+=(const ContourCounts& other)
{
    contours += other.contours;
    not_convex += other.not_convex;
    no_ellipse += other.no_ellipse;
    out_of_range += other.out_of_range;
    return *this;
}

Raster8 red_mask(const Raster8& rgb)
{
    Raster8 mask(rgb.width, rgb.height);
    for (std::size_t i = 0; i < mask.values.size(); ++i)
        mask.values[i] = is_red(&rgb.values[i * 3]) ? 255 : 0;
    return mask;
}

std::vector<Ellipse> find_ellipses(const Raster8& rgb, ContourCounts& counts)
{
    const Raster8 mask = red_mask(rgb);
    cv::Mat clean;
    cv::fastNlMeansDenoising(view_of(mask), clean, denoising_strength);
    cv::threshold(clean, clean, 127, 255, cv::THRESH_BINARY);

    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(clean, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    std::vector<Ellipse> found;
    for (const auto& contour : contours)
    {
        ++counts.contours;
        const auto defect = largest_defect(contour);
        if (!defect || *defect > max_defect_px)
        {
            ++counts.not_convex;
            continue;
        }
        const auto ellipse = fitted(contour, 0.5);
        if (!ellipse)
            ++counts.no_ellipse;
        else if (!in_range(*ellipse))
            ++counts.out_of_range;
        else
            found.push_back(*ellipse);
    }
    return found;
}

const char* opencv_version()
{
    return CV_VERSION;
}

namespace
{

/// Point of the surface that the camera sees at pixel coordinates.
std::optional<Vec3d> surface_point(const Camera& camera, const DepthAt& depth_at, Vec2d pixel)
{
    const auto depth = depth_at(pixel);
    if (!depth)
        return std::nullopt;
    return camera.world_from_camera.translation + camera.ray(pixel.x, pixel.y) * *depth;
}

std::optional<Circle> circle_of(const Ellipse& ellipse, const Camera& camera, const DepthAt& depth_at)
{
    const auto depth = depth_at(ellipse.center);
    const auto center = surface_point(camera, depth_at, ellipse.center);
    if (!depth || !center)
        return std::nullopt;
    const auto half_length = [&](Vec2d half_axis) -> std::optional<double>
    {
        const auto one = surface_point(camera, depth_at, ellipse.center + half_axis);
        const auto other = surface_point(camera, depth_at, ellipse.center - half_axis);
        if (one && other)
            return length(*one - *other) / 2;
        if (one || other)
            return length((one ? *one : *other) - *center);
        return std::nullopt;
    };
    Circle circle{ellipse, *depth, std::nullopt};
    const auto a = half_length(ellipse.half_axis_1);
    const auto b = half_length(ellipse.half_axis_2);
    if (a && b && *a > 0 && *b > 0)
        circle.world = Circle::World{(*a + *b) / 2, std::max(*a / *b, *b / *a)};
    return circle;
}

}  // namespace

std::vector<Circle> circles_on_surface(const std::vector<Ellipse>& ellipses, const Camera& camera, const DepthAt& depth_at)
{
    std::vector<Circle> circles;
    for (const Ellipse& ellipse : ellipses)
        if (const auto circle = circle_of(ellipse, camera, depth_at))
            circles.push_back(*circle);
    return circles;
}

namespace
{

/// The statistics of all circles together of the pictures `drawn` (indices; may repeat).
CircleStatistics circle_statistics(const std::vector<std::vector<Circle>>& pictures, std::span<const std::size_t> drawn)
{
    std::vector<double> depth_2d;
    std::vector<double> radius_px;
    std::vector<double> depth_3d;
    std::vector<double> radius_m;
    std::vector<double> stretch;
    for (const std::size_t i : drawn)
        for (const Circle& circle : pictures[i])
        {
            depth_2d.push_back(circle.depth);
            radius_px.push_back(circle.ellipse.radius_px());
            if (!circle.world)
                continue;
            depth_3d.push_back(circle.depth);
            radius_m.push_back(circle.world->radius_m);
            stretch.push_back(circle.world->stretch);
        }
    return {evaluation::pearson(depth_2d, radius_px), evaluation::pearson(depth_3d, radius_m), evaluation::mean(stretch)};
}

}  // namespace

CircleFigures circle_figures(const std::vector<std::vector<Circle>>& pictures, const evaluation::Bootstrap& bootstrap)
{
    CircleFigures figures;
    for (const auto& picture : pictures)
        for (const Circle& circle : picture)
        {
            ++figures.circles;
            figures.circles_3d += circle.world ? 1 : 0;
        }
    std::vector<std::size_t> all(pictures.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    figures.value = circle_statistics(pictures, all);
    const auto interval = [&](double CircleStatistics::*member)
    {
        const auto drawn_statistic = [&](std::span<const std::size_t> drawn)
        { return circle_statistics(pictures, drawn).*member; };
        return evaluation::bootstrap_interval(pictures.size(), drawn_statistic, bootstrap);
    };
    figures.corr_2d = interval(&CircleStatistics::corr_2d);
    figures.corr_3d = interval(&CircleStatistics::corr_3d);
    figures.stretch = interval(&CircleStatistics::stretch);
    return figures;
}
