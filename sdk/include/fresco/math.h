#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// \file Small fixed-size vectors and rigid transforms. Meters and radians unless a name says otherwise.

namespace fresco
{

template <class T>
struct Vec2
{
    T x{}, y{};
    friend bool operator==(const Vec2&, const Vec2&) = default;
    friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
    friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
    friend constexpr Vec2 operator*(Vec2 a, T s) { return {a.x * s, a.y * s}; }
};

template <class T>
struct Vec3
{
    T x{}, y{}, z{};
    friend bool operator==(const Vec3&, const Vec3&) = default;
    friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
    friend constexpr Vec3 operator*(Vec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
    Vec3& operator+=(Vec3 b) { return *this = *this + b; }
};

using Vec2f = Vec2<float>;
using Vec2d = Vec2<double>;
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
using Rgb8 = std::array<std::uint8_t, 3>;

template <class T>
constexpr T dot(Vec2<T> a, Vec2<T> b)
{
    return a.x * b.x + a.y * b.y;
}
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr T cross(Vec2<T> a, Vec2<T> b)
{
    return a.x * b.y - a.y * b.x;
}
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V>
auto length(V a)
{
    return std::sqrt(dot(a, a));
}
/// The unit vector along `a`; the zero vector stays zero.
template <class V>
V normalized(V a)
{
    const auto norm = length(a);
    return norm > 0 ? a * (1 / norm) : V{};
}
template <class To, class From>
constexpr Vec3<To> vec_cast(Vec3<From> a)
{
    return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

/// Row-major 3x3 matrix.
struct Mat3
{
    std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};
    double operator()(int row, int column) const
    {
        return m[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)];
    }
    double& operator()(int row, int column) { return m[3 * static_cast<std::size_t>(row) + static_cast<std::size_t>(column)]; }
    friend bool operator==(const Mat3&, const Mat3&) = default;
};

Vec3d operator*(const Mat3& a, Vec3d b);
Mat3 operator*(const Mat3& a, const Mat3& b);
Mat3 transposed(const Mat3& a);
double determinant(const Mat3& a);

/// Rotation and translation: `a_from_b.point(p_b)` is p in frame a. Variables are named after both frames (`world_from_camera`).
struct RigidTransform
{
    Mat3 rotation;
    Vec3d translation;

    Vec3d point(Vec3d p) const { return rotation * p + translation; }
    Vec3d direction(Vec3d d) const { return rotation * d; }
    RigidTransform inverse() const;
    /// Largest deviation of RᵀR from the identity, or +inf if det R < 0 or an entry is not finite: 0 for an exact rotation.
    double rotation_error() const;
    friend bool operator==(const RigidTransform&, const RigidTransform&) = default;
};

/// `a_from_c = a_from_b * b_from_c`.
RigidTransform operator*(const RigidTransform& a, const RigidTransform& b);

/// A float32 matrix in somebody's memory: element (row, column) is values[row * row_stride + column * column_stride].
struct MatrixView
{
    const float* values = nullptr;
    std::size_t rows = 0;
    std::size_t columns = 0;
    std::ptrdiff_t row_stride = 0;
    std::ptrdiff_t column_stride = 0;
};

/// c (rows of a x columns of b, row-major) = a b, in blocks that fit the caches (Goto and van de Geijn, "Anatomy of
/// high-performance matrix multiplication", 2008), with the widest vectors that this processor has. Long sums are cut into pieces
/// that depend only on the shapes and added in order: equal bytes for any number of threads. Throws std::invalid_argument where
/// the shapes do not fit.
void multiply_matrices(const MatrixView& a, const MatrixView& b, float* c, int threads);

}  // namespace fresco
