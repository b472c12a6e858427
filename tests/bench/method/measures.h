#pragma once

#include <fresco/torch/features.h>

#include <torch/types.h>

#include <vector>

namespace bench
{

/// Gram matrices by VGG-19 at relu1_1, relu2_1, relu3_1 for the picture, its half and its quarter.
std::vector<torch::Tensor> grams(const fresco::FeatureNetwork& network, const torch::Tensor& picture);

/// Mean over matrices of |a - style|² / |camera - style|²: 1 = nothing of the style was transferred, 0 = all.
double relative_distance(const std::vector<torch::Tensor>& a, const std::vector<torch::Tensor>& style,
                         const std::vector<torch::Tensor>& camera);

/// Signed correlation of the Sobel gradients of luminance, after a Gaussian of 3 px: 1 = every edge is kept.
double edge_correlation(const torch::Tensor& a, const torch::Tensor& b);

/// RGB in [0,1], 3 x H x W, the shorter side (or with `height` the height) resized to `size_px` by area averages;
/// never enlarged, and as it is with 0.
torch::Tensor read_picture(const std::string& file, int size_px, bool height);

/// The same for values; larger pictures only.
torch::Tensor resized(const torch::Tensor& picture, int size_px, bool height = false);

/// An RGBA picture of `below`'s size over it, 3 x H x W in [0,1].
torch::Tensor read_over(const std::string& file, const torch::Tensor& below);

void write_picture(const std::string& file, const std::vector<torch::Tensor>& beside_each_other);
/// Every row's pictures beside each other, white where a row is shorter or lower.
void write_sheet(const std::string& file, const std::vector<std::vector<torch::Tensor>>& rows);

}  // namespace bench
