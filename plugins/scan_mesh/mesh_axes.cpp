#include "mesh_axes.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace scan_mesh
{

fresco::Mat3 axes_rotation(std::string_view axes)
{
    const auto fail = [&](const std::string& what)
    {
        throw fresco::Error("option \"axes\": \"" + std::string(axes.substr(0, 40)) + "\" " + what +
                            "; expected three axes of the file for x, y and z of the world, such as \"x -z y\"");
    };
    fresco::Mat3 rotation;
    rotation.m.fill(0);
    int row = 0;
    double sign = 1;
    for (const char c : axes)
    {
        if (c == ' ')
            continue;
        if (c == '+' || c == '-')
        {
            sign = c == '-' ? -1 : 1;
            continue;
        }
        if (c < 'x' || c > 'z' || row == 3)
            fail("is not valid");
        rotation(row++, c - 'x') = sign;
        sign = 1;
    }
    if (row != 3)
        fail("is not valid");
    const double turn = fresco::determinant(rotation);
    if (turn == 0)
        fail("names an axis twice");
    if (turn < 0)
        fail("mirrors the mesh: flip one sign");
    return rotation;
}

void move_mesh(fresco::Mesh& mesh, double unit_m, const fresco::Mat3& axes, const fresco::RigidTransform& world_from_file)
{
    for (auto& position : mesh.positions)
    {
        position = fresco::vec_cast<float>(world_from_file.point(axes * (fresco::vec_cast<double>(position) * unit_m)));
        if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
            throw fresco::Error("a transformed vertex is out of range; check unit_m and transform");
    }
}

fresco::Vec3d extent_of(const fresco::Mesh& mesh)
{
    if (mesh.positions.empty())
        return {};
    auto low = mesh.positions.front(), high = low;
    for (const auto& p : mesh.positions)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return fresco::vec_cast<double>(high) - fresco::vec_cast<double>(low);
}

}  // namespace scan_mesh
