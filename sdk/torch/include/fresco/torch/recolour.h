#pragma once

#include <fresco/math.h>

#include <torch/types.h>

#include <cstdint>

/// \file Moving the colours of one set of pixels to those of another. Pitié and Kokaram, "The linear Monge-Kantorovitch linear
/// colour mapping for example-based colour transfer", CVMP 2007. Everything in double precision and in a fixed order.

namespace fresco
{

/// Mean and covariance of colours, added one by one.
class ColorMoments
{
  public:
    void add(Vec3d color);
    /// The colours of `other` too.
    void add(const ColorMoments& other);
    std::int64_t count() const { return count_; }
    Vec3d mean() const;       ///< Zero where nothing was added.
    Mat3 covariance() const;  ///< Of the population (divided by count); zero where nothing was added.

  private:
    std::int64_t count_ = 0;
    Vec3d sum_;
    Mat3 products_{{0, 0, 0, 0, 0, 0, 0, 0, 0}};
};

/// The colours of a picture: 3 x H x W or 3 x N, any float type, on any device; with `mask` (bool, the picture's shape less its
/// first dimension) only where it is true.
ColorMoments color_moments(const torch::Tensor& picture, const torch::Tensor& mask = {});

/// An affine map of colours.
struct ColorMap
{
    Mat3 matrix;
    Vec3d offset;
    Vec3d operator()(Vec3d color) const { return matrix * color + offset; }
};

/// Eigenvalues in ascending order and the matching unit eigenvectors as columns of `vectors`; `a` is symmetric (its upper
/// triangle is read).
struct SymmetricEigen
{
    Vec3d values;
    Mat3 vectors;
};
SymmetricEigen symmetric_eigen(const Mat3& a);

/// The map that gives `from` the mean and covariance of `to` and moves colours least: matrix A^-1/2 (A^1/2 B A^1/2)^1/2 A^-1/2
/// for the covariances A, B. Variances of A below 1e-4 (a standard deviation of 0.01 in [0,1]) count as 1e-4, so that a picture
/// that is grey or flat is not given amplified noise for colours. The identity where either has no colours.
ColorMap monge_kantorovich(const ColorMoments& from, const ColorMoments& to);

/// `picture` (3 x H x W or 3 x N) with each colour mapped and clamped to [0,1]; the same type and device.
torch::Tensor recoloured(const torch::Tensor& picture, const ColorMap& map);

}  // namespace fresco
