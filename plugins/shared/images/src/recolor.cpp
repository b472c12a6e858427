#include <fresco/images/recolor.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco
{
namespace
{

constexpr double smallest_variance = 1e-4;

/// V f(Λ) Vᵀ.
template <class Function>
Mat3 of_eigenvalues(const SymmetricEigen& eigen, Function f)
{
    const std::array<double, 3> values{f(eigen.values.x), f(eigen.values.y), f(eigen.values.z)};
    Mat3 result;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
        {
            double sum = 0;
            for (int k = 0; k < 3; ++k)
                sum += eigen.vectors(row, k) * values[static_cast<std::size_t>(k)] * eigen.vectors(column, k);
            result(row, column) = sum;
        }
    return result;
}

/// One Jacobi rotation that makes a(p,q) zero; `v` collects the rotations.
void rotate(Mat3& a, Mat3& v, int p, int q)
{
    if (a(p, q) == 0)
        return;
    const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
    const double t = (theta >= 0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1));
    const double c = 1 / std::sqrt(t * t + 1);
    const double s = t * c;
    for (int k = 0; k < 3; ++k)
    {
        const double kp = a(k, p);
        const double kq = a(k, q);
        a(k, p) = c * kp - s * kq;
        a(k, q) = s * kp + c * kq;
    }
    for (int k = 0; k < 3; ++k)
    {
        const double pk = a(p, k);
        const double qk = a(q, k);
        a(p, k) = c * pk - s * qk;
        a(q, k) = s * pk + c * qk;
    }
    for (int k = 0; k < 3; ++k)
    {
        const double kp = v(k, p);
        const double kq = v(k, q);
        v(k, p) = c * kp - s * kq;
        v(k, q) = s * kp + c * kq;
    }
    a(p, q) = a(q, p) = 0;
}

}  // namespace

void ColorMoments::add(Vec3d color)
{
    ++count_;
    sum_ += color;
    const std::array<double, 3> c{color.x, color.y, color.z};
    for (std::size_t i = 0; i < 9; ++i)
        products_.m[i] += c[i / 3] * c[i % 3];
}

void ColorMoments::add(const ColorMoments& other)
{
    count_ += other.count_;
    sum_ += other.sum_;
    for (std::size_t i = 0; i < 9; ++i)
        products_.m[i] += other.products_.m[i];
}

Vec3d ColorMoments::mean() const
{
    return count_ > 0 ? sum_ * (1.0 / static_cast<double>(count_)) : Vec3d{};
}

Mat3 ColorMoments::covariance() const
{
    Mat3 result{{0, 0, 0, 0, 0, 0, 0, 0, 0}};
    if (count_ == 0)
        return result;
    const Vec3d m = mean();
    const std::array<double, 3> c{m.x, m.y, m.z};
    for (std::size_t i = 0; i < 9; ++i)
        result.m[i] = products_.m[i] / static_cast<double>(count_) - c[i / 3] * c[i % 3];
    // Rounding may leave a channel that does not vary a hair below zero.
    for (const std::size_t i : {0U, 4U, 8U})
        result.m[i] = std::max(result.m[i], 0.0);
    return result;
}

SymmetricEigen symmetric_eigen(const Mat3& matrix)
{
    Mat3 a = matrix;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < row; ++column)
            a(row, column) = a(column, row);
    Mat3 v;
    // Cyclic Jacobi converges quadratically; a 3x3 matrix needs five sweeps, and one that is done costs nothing.
    for (int sweep = 0; sweep < 16; ++sweep)
    {
        rotate(a, v, 0, 1);
        rotate(a, v, 0, 2);
        rotate(a, v, 1, 2);
    }
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return a(i, i) < a(j, j); });
    SymmetricEigen result;
    result.values = {a(order[0], order[0]), a(order[1], order[1]), a(order[2], order[2])};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            result.vectors(row, column) = v(row, order[static_cast<std::size_t>(column)]);
    return result;
}

ColorMap monge_kantorovich(const ColorMoments& from, const ColorMoments& to)
{
    if (from.count() == 0 || to.count() == 0)
        return {};
    const auto eigen = symmetric_eigen(from.covariance());
    const auto root = of_eigenvalues(eigen, [](double v) { return std::sqrt(std::max(v, smallest_variance)); });
    const auto inverse = of_eigenvalues(eigen, [](double v) { return 1 / std::sqrt(std::max(v, smallest_variance)); });
    const auto between = symmetric_eigen(root * to.covariance() * root);
    const auto middle = of_eigenvalues(between, [](double v) { return std::sqrt(std::max(v, 0.0)); });
    ColorMap map;
    map.matrix = inverse * middle * inverse;
    map.offset = to.mean() - map.matrix * from.mean();
    return map;
}

}  // namespace fresco
