#include <fresco/images/lab.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco
{

namespace
{

constexpr float white_x = 0.950456F;
constexpr float white_z = 1.088754F;
constexpr float curve_end = 216.0F / 24389.0F;  // Below, the cube root gives way to a line.
constexpr float slope = 24389.0F / 27.0F;

float linear(float step)
{
    return step <= 0.04045F ? step / 12.92F : std::pow((step + 0.055F) / 1.055F, 2.4F);
}

float curve(float t)
{
    return t > curve_end ? std::cbrt(t) : (slope * t + 16) / 116;
}

Vec3f lab_from_linear(float r, float g, float b)
{
    const float fx = curve((0.412453F * r + 0.357580F * g + 0.180423F * b) / white_x);
    const float fy = curve(0.212671F * r + 0.715160F * g + 0.072169F * b);
    const float fz = curve((0.019334F * r + 0.119193F * g + 0.950227F * b) / white_z);
    return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

}  // namespace

Vec3f lab_from_rgb(Vec3f rgb)
{
    const auto light = [](float step) { return linear(std::clamp(step, 0.0F, 1.0F)); };
    return lab_from_linear(light(rgb.x), light(rgb.y), light(rgb.z));
}

Vec3f rgb_from_lab(Vec3f lab)
{
    const auto curve_back = [](float f)
    {
        const float cube = f * f * f;
        return cube > 216.0F / 24389.0F ? cube : (116 * f - 16) / (24389.0F / 27.0F);
    };
    const auto displayed = [](float light)
    {
        const float v = light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
        return std::clamp(v, 0.0F, 1.0F);
    };
    const float fy = (lab.x + 16) / 116;
    const float x = white_x * curve_back(fy + lab.y / 500);
    const float y = curve_back(fy);
    const float z = white_z * curve_back(fy - lab.z / 200);
    return {displayed(3.240479F * x - 1.537150F * y - 0.498535F * z), displayed(-0.969256F * x + 1.875992F * y + 0.041556F * z),
            displayed(0.055648F * x - 0.204043F * y + 1.057311F * z)};
}

RasterF lab_picture(const Raster8& rgb)
{
    std::array<float, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i)
        light[i] = linear(static_cast<float>(i) / 255);
    RasterF lab(rgb.width, rgb.height, 3);
    for (std::size_t i = 0; i + 2 < rgb.values.size(); i += 3)
    {
        const Vec3f color = lab_from_linear(light[rgb.values[i]], light[rgb.values[i + 1]], light[rgb.values[i + 2]]);
        lab.values[i] = color.x;
        lab.values[i + 1] = color.y;
        lab.values[i + 2] = color.z;
    }
    return lab;
}

namespace
{

constexpr double smallest_variance = 1e-4;

/// V f(Λ) Vᵀ.
template <class Function>
Mat3 of_eigenvalues(const SymmetricEigen& eigen, Function f)
{
    const Mat3 diagonal{{f(eigen.values.x), 0, 0, 0, f(eigen.values.y), 0, 0, 0, f(eigen.values.z)}};
    return eigen.vectors * diagonal * transposed(eigen.vectors);
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
    const auto turn = [&](double& x, double& y)
    {
        const double before = x;
        x = c * before - s * y;
        y = s * before + c * y;
    };
    for (int k = 0; k < 3; ++k)
        turn(a(k, p), a(k, q));
    for (int k = 0; k < 3; ++k)
        turn(a(p, k), a(q, k));
    for (int k = 0; k < 3; ++k)
        turn(v(k, p), v(k, q));
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
