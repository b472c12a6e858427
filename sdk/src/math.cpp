#include <fresco/math.h>

#include <algorithm>
#include <limits>

namespace fresco
{

Vec3d operator*(const Mat3& a, Vec3d b)
{
    return {a(0, 0) * b.x + a(0, 1) * b.y + a(0, 2) * b.z, a(1, 0) * b.x + a(1, 1) * b.y + a(1, 2) * b.z,
            a(2, 0) * b.x + a(2, 1) * b.y + a(2, 2) * b.z};
}

Mat3 operator*(const Mat3& a, const Mat3& b)
{
    Mat3 product;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
            product(row, column) = a(row, 0) * b(0, column) + a(row, 1) * b(1, column) + a(row, 2) * b(2, column);
    return product;
}

Mat3 transposed(const Mat3& a)
{
    return {{a(0, 0), a(1, 0), a(2, 0), a(0, 1), a(1, 1), a(2, 1), a(0, 2), a(1, 2), a(2, 2)}};
}

double determinant(const Mat3& a)
{
    return a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) - a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
           a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0));
}

RigidTransform RigidTransform::inverse() const
{
    const Mat3 inverse_rotation = transposed(rotation);
    return {inverse_rotation, -(inverse_rotation * translation)};
}

double RigidTransform::rotation_error() const
{
    const Mat3 gram = transposed(rotation) * rotation;
    double largest = 0;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column)
        {
            const double deviation = std::abs(gram(row, column) - (row == column ? 1 : 0));
            if (!std::isfinite(deviation))
                return std::numeric_limits<double>::infinity();
            largest = std::max(largest, deviation);
        }
    const bool finite_position = std::isfinite(translation.x) && std::isfinite(translation.y) && std::isfinite(translation.z);
    if (!finite_position || determinant(rotation) < 0)
        return std::numeric_limits<double>::infinity();
    return largest;
}

RigidTransform operator*(const RigidTransform& a, const RigidTransform& b)
{
    return {a.rotation * b.rotation, a.point(b.translation)};
}

}  // namespace fresco
