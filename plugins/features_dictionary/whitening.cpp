#include "whitening.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace dictionary
{
namespace
{

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

torch::Tensor column_means(const torch::Tensor& samples)
{
    const auto count = samples.size(0);
    const auto width = samples.size(1);
    std::vector<double> sums(static_cast<std::size_t>(width), 0.0);
    const float* value = samples.data_ptr<float>();
    for (std::int64_t i = 0; i < count; ++i)
        for (std::int64_t j = 0; j < width; ++j)
            sums[static_cast<std::size_t>(j)] += static_cast<double>(*value++);
    auto mean = at::empty({width}, at::kFloat);
    for (std::int64_t j = 0; j < width; ++j)
        mean.data_ptr<float>()[j] = static_cast<float>(sums[static_cast<std::size_t>(j)] / static_cast<double>(count));
    return mean;
}

}  // namespace

Whitening learn_whitening(const torch::Tensor& samples, double epsilon)
{
    const auto values = samples.contiguous();
    const auto width = values.size(1);
    const auto mean = column_means(values);
    const auto centred = values - mean;
    const auto products = fresco::matrix_product(centred.t().contiguous(), centred);

    const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> sums(products.data_ptr<float>(),
                                                                                                       width, width);
    Matrix covariance = sums.cast<double>() / static_cast<double>(values.size(0));
    const double mean_eigenvalue = covariance.trace() / static_cast<double>(width);
    // A picture of one colour has no variance at all; any positive floor keeps the factorisation defined.
    covariance.diagonal().array() += epsilon * mean_eigenvalue + 1e-12;

    const Eigen::LLT<Matrix> factor(covariance);
    const Matrix inverse = factor.matrixL().solve(Matrix::Identity(width, width));
    Whitening result{mean, at::empty({width, width}, at::kFloat)};
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(result.transform.data_ptr<float>(), width,
                                                                                      width) = inverse.cast<float>();
    return result;
}

}  // namespace dictionary
