#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>

/// \file Luma, CIE L*a*b*, and moving the colors of one set of pixels to those of another: Pitié and Kokaram, "The linear
/// Monge-Kantorovitch linear color mapping for example-based color transfer", CVMP 2007. Everything in a fixed order.

namespace fresco
{

/// How bright a displayed color is, 0..255: the luma of Rec. 601.
inline double luma(const std::uint8_t* rgb)
{
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

/// Luma in steps of 2^-15, before rounding.
inline int fixed_luma(const std::uint8_t* rgb)
{
    return 9798 * rgb[0] + 19235 * rgb[1] + 3735 * rgb[2];
}

/// CIE L*a*b* (D65, 2 degrees) of displayed sRGB: L* in 0..100. RGB in [0,1]; values outside are clamped. IEC 61966-2-1 and
/// CIE 15.
Vec3f lab_from_rgb(Vec3f rgb);
/// The way back; colors outside of the gamut are clamped to [0,1].
Vec3f rgb_from_lab(Vec3f lab);

/// Every pixel of an 8-bit RGB picture: H x W x 3.
RasterF lab_picture(const Raster8& rgb);

/// Mean and covariance of colors, added one by one.
class ColorMoments
{
  public:
    void add(Vec3d color);
    /// The colors of `other` too.
    void add(const ColorMoments& other);
    std::int64_t count() const { return count_; }
    Vec3d mean() const;       ///< Zero where nothing was added.
    Mat3 covariance() const;  ///< Covariance of the population (divided by count); zero where nothing was added.

  private:
    std::int64_t count_ = 0;
    Vec3d sum_;
    Mat3 products_{{0, 0, 0, 0, 0, 0, 0, 0, 0}};
};

/// An affine map of colors.
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

/// The map that gives `from` the mean and covariance of `to` and moves colors least: matrix A^-1/2 (A^1/2 B A^1/2)^1/2 A^-1/2
/// for the covariances A, B. Variances of A below 1e-4 (a standard deviation of 0.01 in [0,1]) count as 1e-4, so that a picture
/// that is gray or flat is not given amplified noise for colors. The identity where either has no colors.
ColorMap monge_kantorovich(const ColorMoments& from, const ColorMoments& to);

}  // namespace fresco
