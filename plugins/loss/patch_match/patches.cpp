#define EIGEN_DONT_PARALLELIZE

#include "patches.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <vector>

namespace patch_match
{

torch::Tensor extract_patches(const torch::Tensor& picture, const PatchGrid& grid)
{
    const auto source = picture.detach().to(at::kFloat).contiguous();
    auto result = at::empty({grid.count(), patch_values}, at::kFloat);
    float* out = result.data_ptr<float>();
    for (std::int64_t i = 0; i < grid.count(); ++i)
        for (std::int64_t c = 0; c < 3; ++c)
            for (std::int64_t row = 0; row < patch_size; ++row)
                out = std::copy_n(source.data_ptr<float>() + (c * grid.height + grid.y(i) + row) * grid.width + grid.x(i),
                                  patch_size, out);
    return result;
}

torch::Tensor whole_patches(const torch::Tensor& mask, const PatchGrid& grid)
{
    const auto source = mask.contiguous();
    // Sums over rectangles of the mask from its upper left corner.
    const auto pitch = static_cast<std::size_t>(grid.width) + 1;
    std::vector<std::int64_t> sums(pitch * (static_cast<std::size_t>(grid.height) + 1), 0);
    const bool* value = source.data_ptr<bool>();
    for (std::size_t y = 1; y <= static_cast<std::size_t>(grid.height); ++y)
        for (std::size_t x = 1; x < pitch; ++x)
            sums[y * pitch + x] =
                (*value++ ? 1 : 0) + sums[y * pitch + x - 1] + sums[(y - 1) * pitch + x] - sums[(y - 1) * pitch + x - 1];
    auto result = at::empty({grid.count()}, at::kBool);
    for (std::int64_t i = 0; i < grid.count(); ++i)
    {
        const auto upper = static_cast<std::size_t>(grid.y(i)) * pitch + static_cast<std::size_t>(grid.x(i));
        const auto lower = upper + patch_size * pitch;
        result.data_ptr<bool>()[i] =
            sums[lower + patch_size] - sums[lower] - sums[upper + patch_size] + sums[upper] == patch_size * patch_size;
    }
    return result;
}

torch::Tensor halved(const torch::Tensor& picture)
{
    if (picture.size(1) < 2 || picture.size(2) < 2)
        return picture.new_zeros({picture.size(0), picture.size(1) / 2, picture.size(2) / 2});
    return at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0);
}

torch::Tensor halved_mask(const torch::Tensor& mask)
{
    const auto height = mask.size(0) / 2;
    const auto width = mask.size(1) / 2;
    return mask.narrow(0, 0, height * 2).narrow(1, 0, width * 2).reshape({height, 2, width, 2}).all(3).all(1);
}

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

fresco::ColorMoments color_moments(const torch::Tensor& picture)
{
    const auto values = picture.detach().to(at::kCPU, at::kDouble).contiguous();
    const auto pixels = values.size(1) * values.size(2);
    const double* v = values.data_ptr<double>();
    fresco::ColorMoments moments;
    for (std::int64_t i = 0; i < pixels; ++i)
        moments.add({v[i], v[pixels + i], v[2 * pixels + i]});
    return moments;
}

torch::Tensor recolored(const torch::Tensor& picture, const fresco::ColorMap& map)
{
    const std::array<double, 3> offset{map.offset.x, map.offset.y, map.offset.z};
    std::vector<torch::Tensor> channels;
    for (int row = 0; row < 3; ++row)
        channels.push_back((picture[0] * map.matrix(row, 0) + picture[1] * map.matrix(row, 1) + picture[2] * map.matrix(row, 2) +
                            offset[static_cast<std::size_t>(row)])
                               .clamp(0, 1));
    return at::stack(channels);
}

}  // namespace patch_match
