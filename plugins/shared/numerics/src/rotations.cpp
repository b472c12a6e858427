#include <fresco/numerics/rotations.h>

#include <cmath>

namespace fresco::numerics
{

Mat3 rotation_by(Vec3d turn)
{
    const double angle = length(turn);
    const Vec3d axis = normalized(turn);
    const double s = std::sin(angle);
    const double c = std::cos(angle);
    const double r = 1 - c;
    return {{c + axis.x * axis.x * r, axis.x * axis.y * r - axis.z * s, axis.x * axis.z * r + axis.y * s,
             axis.y * axis.x * r + axis.z * s, c + axis.y * axis.y * r, axis.y * axis.z * r - axis.x * s,
             axis.z * axis.x * r - axis.y * s, axis.z * axis.y * r + axis.x * s, c + axis.z * axis.z * r}};
}

Mat3 rotation_of(double w, double x, double y, double z)
{
    return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
             2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
}

}  // namespace fresco::numerics
