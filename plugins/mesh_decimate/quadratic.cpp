#include "quadratic.h"

#include <algorithm>
#include <cmath>
#include <limits>

using fresco::Vec3d;

namespace
{

/// Of lines at borders against planes: as high as the border's drift asks for.
constexpr double line_weight = 0.6;
/// Pull toward the middle, against the stiffness of the surface: decides only where the surface does not.
constexpr double pull_share = 1e-7;
/// A point farther than this many edge lengths from the middle is not used.
constexpr double farthest_lengths = 2;
/// Price of the length of an edge where the surface is flat and every point costs nothing.
constexpr double length_price = 1e-9;

/// The inverse of a symmetric matrix times its determinant.
struct Adjugate
{
    std::array<double, 6> m;
    double determinant;

    explicit Adjugate(const std::array<double, 6>& h)
        : m{h[3] * h[5] - h[4] * h[4], h[2] * h[4] - h[1] * h[5], h[1] * h[4] - h[2] * h[3],
            h[0] * h[5] - h[2] * h[2], h[1] * h[2] - h[0] * h[4], h[0] * h[3] - h[1] * h[1]},
          determinant(h[0] * m[0] + h[1] * m[1] + h[2] * m[2])
    {
    }
    Vec3d times(Vec3d v) const
    {
        return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z, m[2] * v.x + m[4] * v.y + m[5] * v.z};
    }
};

}  // namespace

double Quadratic::operator()(Vec3d x) const
{
    const double curved =
        x.x * (h[0] * x.x + 2 * (h[1] * x.y + h[2] * x.z)) + x.y * (h[3] * x.y + 2 * h[4] * x.z) + x.z * h[5] * x.z;
    return curved - 2 * dot(k, x) + c;
}

void Quadratic::add(const Quadratic& other, double weight)
{
    for (std::size_t i = 0; i < h.size(); ++i)
        h[i] += weight * other.h[i];
    k += other.k * weight;
    c += weight * other.c;
}

Quadratic plane_error(Vec3d a, Vec3d b, Vec3d c)
{
    const Vec3d across = cross(b - a, c - a);
    const double squared = dot(across, across);
    if (!(squared > 0))
        return {};
    // across is twice the area long, so its square times area^-0.75 is left.
    const double root = std::sqrt(std::sqrt(squared));
    const Vec3d n = across * (1 / (root * std::sqrt(root)));
    const Vec3d m = across;
    const double d = dot(m, a);
    return {{n.x * m.x, n.x * m.y, n.x * m.z, n.y * m.y, n.y * m.z, n.z * m.z}, n * d, dot(n, a) * d};
}

Quadratic line_error(Vec3d a, Vec3d b)
{
    // The squared area of the parallelogram that x spans with the edge: |a x b - x x (b - a)|².
    const Vec3d e = b - a;
    const Vec3d r = cross(a, b);
    const double squared = dot(e, e);
    return {{squared - e.x * e.x, -e.x * e.y, -e.x * e.z, squared - e.y * e.y, -e.y * e.z, squared - e.z * e.z},
            cross(e, r),
            dot(r, r)};
}

Placement place(const Quadratic& planes, const Quadratic* lines, Vec3d u, Vec3d v)
{
    const Vec3d middle = (u + v) * 0.5;
    const double squared_length = dot(u - v, u - v);
    Quadratic error = planes;
    if (lines != nullptr)  // the power brings both to meters to the power of 4.5
        error.add(*lines, 36 * line_weight * std::sqrt(std::sqrt(squared_length)));
    const double stiffness = error.trace();
    constexpr double none = std::numeric_limits<double>::infinity();
    if (!(stiffness > 0))
        return {middle, none};
    std::array<double, 6> h = error.h;
    const double pull = pull_share * stiffness;
    for (const std::size_t i : {0U, 3U, 5U})
        h[i] += pull;
    const Adjugate adjugate(h);
    const Vec3d point = adjugate.times(error.k + middle * pull) * (1 / adjugate.determinant);
    const Vec3d away = point - middle;
    if (!(dot(away, away) <= farthest_lengths * farthest_lengths * squared_length))
        return {middle, none};
    return {point, std::max(error(point), 0.0) + length_price * stiffness * squared_length};
}
