#include "style_patches.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>

namespace patch_match
{

StylePatches make_style_patches(const torch::Tensor& picture, std::int64_t most, int dimensions)
{
    PatchGrid grid{picture.size(2), picture.size(1), 1};
    while (grid.count() > most)
        ++grid.stride;
    StylePatches style;
    style.patches = extract_patches(picture, grid);
    style.mean = fresco::ordered_mean(style.patches, 0);

    const auto centerd = style.patches - style.mean;
    const auto sums = fresco::matrix_product(centerd.t().contiguous(), centerd).contiguous();
    using Float = Eigen::Matrix<float, patch_values, patch_values, Eigen::RowMajor>;
    const Eigen::MatrixXd covariance =
        Eigen::Map<const Float>(sums.data_ptr<float>()).cast<double>() / static_cast<double>(grid.count());
    style.total_variance = covariance.trace();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
    const int kept = std::min(dimensions, patch_values);
    style.basis = at::empty({patch_values, kept}, at::kFloat);
    for (int column = 0; column < kept; ++column)
        for (int row = 0; row < patch_values; ++row)
            style.basis.data_ptr<float>()[row * kept + column] =
                static_cast<float>(solver.eigenvectors()(row, patch_values - 1 - column));
    style.keys = project(style, style.patches);
    return style;
}

torch::Tensor project(const StylePatches& style, const torch::Tensor& rows)
{
    return fresco::matrix_product(rows - style.mean, style.basis).contiguous();
}

}  // namespace patch_match
