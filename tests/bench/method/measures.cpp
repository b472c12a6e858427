#include "measures.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace bench
{
namespace
{

cv::Mat to_mat(const torch::Tensor& picture)
{
    const auto values = picture.detach().to(at::kFloat).permute({1, 2, 0}).contiguous();
    return cv::Mat(static_cast<int>(values.size(0)), static_cast<int>(values.size(1)), CV_32FC3, values.data_ptr<float>())
        .clone();
}

torch::Tensor planes(const cv::Mat& values)
{
    return at::from_blob(values.data, {values.rows, values.cols, 3}, at::kFloat)
        .permute({2, 0, 1})
        .clone(at::MemoryFormat::Contiguous);
}

/// 8-bit BGR as 3 x H x W in [0,1].
torch::Tensor to_tensor(const cv::Mat& bgr)
{
    cv::Mat rgb;
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    rgb.convertTo(rgb, CV_32FC3, 1 / 255.0);
    return planes(rgb);
}

void gradients(const torch::Tensor& picture, cv::Mat& dx, cv::Mat& dy)
{
    cv::Mat grey;
    cv::cvtColor(to_mat(picture), grey, cv::COLOR_RGB2GRAY);
    cv::GaussianBlur(grey, grey, {0, 0}, 3);
    cv::Sobel(grey, dx, CV_32F, 1, 0);
    cv::Sobel(grey, dy, CV_32F, 0, 1);
}

}  // namespace

std::vector<torch::Tensor> grams(const fresco::FeatureNetwork& network, const torch::Tensor& picture)
{
    std::vector<torch::Tensor> result;
    auto scaled = picture.to(at::kFloat);
    for (int scale = 0; scale < 3; ++scale)
    {
        for (const auto& map : network.encode(scaled, {"relu1_1", "relu2_1", "relu3_1"}))
        {
            const auto flat = map.flatten(1).contiguous();
            result.push_back(fresco::matrix_product(flat, flat.t().contiguous()) / static_cast<double>(flat.size(1)));
        }
        scaled = at::avg_pool2d(scaled.unsqueeze(0), {2, 2}).squeeze(0);
    }
    return result;
}

double relative_distance(const std::vector<torch::Tensor>& a, const std::vector<torch::Tensor>& style,
                         const std::vector<torch::Tensor>& camera)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - style[i]).pow(2).sum().item<double>() / (camera[i] - style[i]).pow(2).sum().item<double>();
    return sum / static_cast<double>(a.size());
}

double edge_correlation(const torch::Tensor& a, const torch::Tensor& b)
{
    cv::Mat ax;
    cv::Mat ay;
    cv::Mat bx;
    cv::Mat by;
    gradients(a, ax, ay);
    gradients(b, bx, by);
    const double product = ax.dot(bx) + ay.dot(by);
    return product / std::sqrt((ax.dot(ax) + ay.dot(ay)) * (bx.dot(bx) + by.dot(by)));
}

torch::Tensor read_picture(const std::string& file, int size_px, bool height)
{
    cv::Mat picture = cv::imread(file, cv::IMREAD_COLOR);
    if (picture.empty())
        throw fresco::MissingInput(file + ": cannot be read as a picture");
    const auto values = to_tensor(picture);
    return size_px > 0 ? resized(values, size_px, height) : values;
}

torch::Tensor resized(const torch::Tensor& picture, int size_px, bool height)
{
    cv::Mat values = to_mat(picture);
    const double scale = static_cast<double>(size_px) / (height ? values.rows : std::min(values.rows, values.cols));
    if (scale >= 1)
        return picture;
    cv::resize(values, values,
               {static_cast<int>(std::lround(values.cols * scale)), static_cast<int>(std::lround(values.rows * scale))}, 0, 0,
               cv::INTER_AREA);
    return planes(values);
}

torch::Tensor read_over(const std::string& file, const torch::Tensor& below)
{
    const cv::Mat picture = cv::imread(file, cv::IMREAD_UNCHANGED);
    if (picture.empty() || picture.channels() != 4)
        throw fresco::MissingInput(file + ": cannot be read as a picture with four channels");
    if (picture.rows != below.size(1) || picture.cols != below.size(2))
        throw fresco::MissingInput(file + ": is not of the camera picture's size");
    std::vector<cv::Mat> channels;
    cv::split(picture, channels);
    const cv::Mat alpha = channels[3];
    channels.pop_back();
    cv::Mat colours;
    cv::merge(channels, colours);
    cv::Mat share;
    alpha.convertTo(share, CV_32F, 1 / 255.0);
    const auto covered = at::from_blob(share.data, {1, share.rows, share.cols}, at::kFloat);
    return to_tensor(colours) * covered + below * (1 - covered);
}

void write_picture(const std::string& file, const std::vector<torch::Tensor>& beside_each_other)
{
    write_sheet(file, {beside_each_other});
}

void write_sheet(const std::string& file, const std::vector<std::vector<torch::Tensor>>& rows)
{
    constexpr int gap = 4;
    int width = 0;
    int height = 0;
    for (const auto& row : rows)
    {
        int across = 0;
        int down = 0;
        for (const auto& picture : row)
        {
            across += static_cast<int>(picture.size(2)) + gap;
            down = std::max(down, static_cast<int>(picture.size(1)) + gap);
        }
        width = std::max(width, across);
        height += down;
    }
    cv::Mat sheet(height, width, CV_32FC3, cv::Scalar(1, 1, 1));
    int y = 0;
    for (const auto& row : rows)
    {
        int x = 0;
        int down = 0;
        for (const auto& picture : row)
        {
            const cv::Mat values = to_mat(picture);
            values.copyTo(sheet(cv::Rect(x, y, values.cols, values.rows)));
            x += values.cols + gap;
            down = std::max(down, values.rows + gap);
        }
        y += down;
    }
    cv::cvtColor(sheet, sheet, cv::COLOR_RGB2BGR);
    sheet.convertTo(sheet, CV_8UC3, 255);
    cv::imwrite(file, sheet);
}

}  // namespace bench
