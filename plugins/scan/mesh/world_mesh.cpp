#include "world_mesh.h"

#include <fresco/error.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

namespace scan_mesh
{
namespace
{

using fresco::Triangle;

/// V: the first vertex at the same position with the same color. -0 counts as 0.
std::vector<std::uint32_t> first_vertices(const fresco::Mesh& mesh)
{
    const auto key = [&](std::uint32_t v)
    {
        const fresco::Vec3f p = mesh.positions[v];
        return std::tuple(p.x, p.y, p.z, mesh.colors.empty() ? fresco::Rgb8{} : mesh.colors[v]);
    };
    return fresco::numerics::first_equal(mesh.positions.size(), key);
}

/// F: whether a face repeats one before it, whatever its side, or names a vertex twice.
std::vector<std::uint8_t> repeated_faces(const std::vector<Triangle>& triangles)
{
    std::vector<Triangle> sorted = triangles;
    for (Triangle& t : sorted)
        std::ranges::sort(t);
    const auto first = fresco::numerics::first_equal(sorted.size(), [&](std::uint32_t face) { return sorted[face]; });
    std::vector<std::uint8_t> repeated(triangles.size(), 0);
    for (std::size_t face = 0; face < sorted.size(); ++face)
    {
        const Triangle& t = sorted[face];
        repeated[face] = t[0] == t[1] || t[1] == t[2] || first[face] != face;
    }
    return repeated;
}

}  // namespace

std::size_t join_vertices(fresco::Mesh& mesh)
{
    const auto first = first_vertices(mesh);
    std::vector<Triangle> joined = mesh.triangles;
    for (Triangle& t : joined)
        for (std::uint32_t& v : t)
            v = first[v];
    const auto repeated = repeated_faces(joined);
    for (std::size_t face = 0; face < joined.size(); ++face)
        if (repeated[face] != 0)
            joined[face] = mesh.triangles[face];
    mesh.triangles = std::move(joined);

    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            used[v] = 1;
    // Vertices without faces stay where nothing is joined with them.
    std::vector<std::uint32_t> number(mesh.positions.size());
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < number.size(); ++v)
    {
        if (used[v] == 0 && first[v] != v)
            continue;
        number[v] = count;
        mesh.positions[count] = mesh.positions[v];
        if (!mesh.colors.empty())
            mesh.colors[count] = mesh.colors[v];
        ++count;
    }
    const std::size_t removed = mesh.positions.size() - count;
    mesh.positions.resize(count);
    if (!mesh.colors.empty())
        mesh.colors.resize(count);
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t)
            v = number[v];
    return removed;
}

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

void to_world(std::vector<fresco::Vec3d>& positions, double unit_m, const fresco::Mat3& axes,
              const fresco::RigidTransform& world_from_file)
{
    for (auto& position : positions)
    {
        position = world_from_file.point(axes * (position * unit_m));
        const auto stored = fresco::vec_cast<float>(position);
        if (!std::isfinite(stored.x) || !std::isfinite(stored.y) || !std::isfinite(stored.z))
            throw fresco::Error("a transformed vertex is out of range; check unit_m and transform");
    }
}

fresco::Vec3d extent_of(const fresco::Mesh& mesh)
{
    fresco::numerics::Bounds<float> box;
    for (const auto& p : mesh.positions)
        box.add(p);
    return fresco::vec_cast<double>(box.high) - fresco::vec_cast<double>(box.low);
}

}  // namespace scan_mesh
