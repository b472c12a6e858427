#include "overlay.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <cmath>
#include <numbers>

using namespace fresco;

namespace
{
constexpr int fraction_bits = 4;

/// Pixel coordinates as OpenCV's drawing takes them: centers at whole numbers, in sixteenths.
cv::Point drawn_at(Vec2d p)
{
    const double scale = 1 << fraction_bits;
    return {static_cast<int>(std::lround((p.x - 0.5) * scale)), static_cast<int>(std::lround((p.y - 0.5) * scale))};
}
}  // namespace

Raster8 overlay(const Raster8& rgb, const std::vector<Circle>& circles)
{
    Raster8 result = rgb;
    cv::Mat picture(result.height, result.width, CV_8UC3, result.values.data());
    for (const Circle& circle : circles)
    {
        const Ellipse& e = circle.ellipse;
        const cv::Scalar color = circle.world ? cv::Scalar(0, 200, 0) : cv::Scalar(0, 0, 255);
        const double scale = 1 << fraction_bits;
        const cv::Size half(static_cast<int>(std::lround(length(e.half_axis_1) * scale)),
                            static_cast<int>(std::lround(length(e.half_axis_2) * scale)));
        const double angle = std::atan2(e.half_axis_1.y, e.half_axis_1.x) * 180 / std::numbers::pi;
        cv::ellipse(picture, drawn_at(e.center), half, angle, 0, 360, color, 2, cv::LINE_AA, fraction_bits);
        for (const Vec2d axis : {e.half_axis_1, e.half_axis_2})
            cv::line(picture, drawn_at(e.center - axis), drawn_at(e.center + axis), color, 1, cv::LINE_AA, fraction_bits);
    }
    return result;
}
