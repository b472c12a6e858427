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
    cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
    const double scale = static_cast<double>(size_px) / (height ? picture.rows : std::min(picture.rows, picture.cols));
    if (scale < 1)
        cv::resize(picture, picture,
                   {static_cast<int>(std::lround(picture.cols * scale)), static_cast<int>(std::lround(picture.rows * scale))}, 0,
                   0, cv::INTER_AREA);
    cv::Mat values;
    picture.convertTo(values, CV_32FC3, 1 / 255.0);
    return at::from_blob(values.data, {values.rows, values.cols, 3}, at::kFloat)
        .permute({2, 0, 1})
        .clone(at::MemoryFormat::Contiguous);
}

void write_picture(const std::string& file, const std::vector<torch::Tensor>& beside_each_other)
{
    int height = 0;
    for (const auto& picture : beside_each_other)
        height = std::max(height, static_cast<int>(picture.size(1)));
    std::vector<cv::Mat> columns;
    for (const auto& picture : beside_each_other)
    {
        cv::Mat column;
        cv::copyMakeBorder(to_mat(picture), column, 0, height - static_cast<int>(picture.size(1)), 0, 4, cv::BORDER_CONSTANT,
                           cv::Scalar(1, 1, 1));
        columns.push_back(column);
    }
    cv::Mat sheet;
    cv::hconcat(columns, sheet);
    cv::cvtColor(sheet, sheet, cv::COLOR_RGB2BGR);
    sheet.convertTo(sheet, CV_8UC3, 255);
    cv::imwrite(file, sheet);
}

}  // namespace bench
