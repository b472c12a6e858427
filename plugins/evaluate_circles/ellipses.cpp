#include "ellipses.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/photo.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

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

Raster8 raster_of(const cv::Mat& mask)
{
    Raster8 result(mask.cols, mask.rows);
    cv::Mat target(mask.rows, mask.cols, CV_8UC1, result.values.data());
    mask.copyTo(target);
    return result;
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
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2] > 0.15 * 255;
}

cv::Mat released_mask(const cv::Mat& rgb)
{
    cv::Mat hsv;
    cv::cvtColor(rgb, hsv, cv::COLOR_RGB2HSV);
    cv::Mat low;
    cv::inRange(hsv, cv::Scalar(0, 153, 153), cv::Scalar(15, 255, 255), low);
    cv::Mat high;
    cv::inRange(hsv, cv::Scalar(160, 102, 102), cv::Scalar(179, 255, 255), high);
    cv::Mat gray;
    cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
    cv::Mat filtered;
    gray.copyTo(filtered, low | high);
    cv::threshold(filtered, filtered, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    return filtered;
}

/// Nothing where the contour is too ragged to have a hull of ordered points.
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

bool in_range(const Ellipse& ellipse, Protocol protocol)
{
    if (protocol == Protocol::paper)
        return ellipse.radius_px() >= 10 && ellipse.radius_px() <= 1000 && ellipse.stretch() <= 10;
    const double area = 4 * length(ellipse.half_axis_1) * length(ellipse.half_axis_2);
    return area > 10 && area < 10'000 && ellipse.stretch() < 10;
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

Raster8 red_mask(const Raster8& rgb, Protocol protocol)
{
    if (protocol == Protocol::released)
        return raster_of(released_mask(view_of(rgb)));
    Raster8 mask(rgb.width, rgb.height);
    for (std::size_t i = 0; i < mask.values.size(); ++i)
        mask.values[i] = is_red(&rgb.values[i * 3]) ? 255 : 0;
    return mask;
}

std::vector<Ellipse> find_ellipses(const Raster8& rgb, Protocol protocol, ContourCounts& counts)
{
    const Raster8 mask = red_mask(rgb, protocol);
    cv::Mat clean;
    cv::fastNlMeansDenoising(view_of(mask), clean, denoising_strength);
    const bool otsu = protocol == Protocol::released;
    cv::threshold(clean, clean, 127, 255, cv::THRESH_BINARY | (otsu ? cv::THRESH_OTSU : 0));

    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(clean, contours, otsu ? cv::RETR_TREE : cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
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
        const auto ellipse = fitted(contour, protocol == Protocol::paper ? 0.5 : 0);
        if (!ellipse)
            ++counts.no_ellipse;
        else if (!in_range(*ellipse, protocol))
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
