#include "sharpness.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

double sharpness(const fresco::Raster<std::uint8_t>& rgb, int width, int height)
{
    // OpenCV has no read-only view: the matrix is not written to.
    const cv::Mat picture(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.values.data()));
    cv::Mat sampled;
    cv::resize(picture, sampled, cv::Size(width, height), 0, 0, cv::INTER_NEAREST);
    cv::Mat grey;
    cv::cvtColor(sampled, grey, cv::COLOR_RGB2GRAY);
    cv::Mat edges;
    cv::Laplacian(grey, edges, CV_64F);
    cv::Scalar mean, deviation;
    cv::meanStdDev(edges, mean, deviation);
    return deviation[0] * deviation[0];
}
