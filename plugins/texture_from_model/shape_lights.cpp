#include "shape_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace from_model
{

using fresco::Mesh;
using fresco::Vec3d;

namespace
{

// No two sides of a box look at the lamp at a similar angle.
constexpr Vec3d lamp_direction{0.22, 0.53, 0.82};
constexpr double lamp_diagonals = 2;
constexpr double middle_lightness = 55;
constexpr double lamp_range = 27;
constexpr double bend_range = 8;
const double crease_cosine = std::cos(40 * std::acos(-1.0) / 180);

Vec3d position(const Mesh& mesh, std::uint32_t vertex)
{
    return fresco::vec_cast<double>(mesh.positions[vertex]);
}

/// F: twice the area times the normal.
std::vector<Vec3d> area_normals(const Mesh& mesh)
{
    std::vector<Vec3d> normals;
    normals.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles)
    {
        const Vec3d a = position(mesh, t[0]);
        normals.push_back(cross(position(mesh, t[1]) - a, position(mesh, t[2]) - a));
    }
    return normals;
}

/// The faces around each vertex.
struct VertexFaces
{
    std::vector<std::size_t> begin;    ///< V + 1
    std::vector<std::uint32_t> faces;  ///< 3F

    explicit VertexFaces(const Mesh& mesh) : begin(mesh.positions.size() + 1, 0), faces(3 * mesh.triangles.size())
    {
        for (const auto& t : mesh.triangles)
            for (const std::uint32_t v : t)
                ++begin[v + 1];
        for (std::size_t v = 1; v < begin.size(); ++v)
            begin[v] += begin[v - 1];
        std::vector<std::size_t> next = begin;
        for (std::uint32_t face = 0; face < mesh.triangles.size(); ++face)
            for (const std::uint32_t v : mesh.triangles[face])
                faces[next[v]++] = face;
    }
};

/// V: how far the neighbors lie below the tangent plane, as the mean sine of the angle; positive where the surface is convex.
std::vector<double> vertex_bends(const Mesh& mesh)
{
    const auto normals = fresco::vertex_normals(mesh);
    std::vector<double> sums(mesh.positions.size(), 0);
    std::vector<double> counts(mesh.positions.size(), 0);
    const auto add = [&](std::uint32_t v, std::uint32_t neighbor)
    {
        sums[v] += dot(fresco::vec_cast<double>(normals[v]), normalized(position(mesh, v) - position(mesh, neighbor)));
        ++counts[v];
    };
    for (const auto& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i)
        {
            add(t[i], t[(i + 1) % 3]);
            add(t[(i + 1) % 3], t[i]);
        }
    for (std::size_t v = 0; v < sums.size(); ++v)
        sums[v] = counts[v] > 0 ? sums[v] / counts[v] : 0;
    return sums;
}

Vec3d lamp_of(const Mesh& mesh)
{
    Vec3d low = position(mesh, mesh.triangles[0][0]);
    Vec3d high = low;
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t)
        {
            const Vec3d p = position(mesh, v);
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
    return (low + high) * 0.5 + lamp_direction * (lamp_diagonals * length(high - low));
}

/// CIE 15: the light of a lightness L*.
double light_of(double lightness)
{
    const double root = (lightness + 16) / 116;
    return root * root * root;
}

}  // namespace

std::vector<float> shape_lights(const Mesh& mesh)
{
    const auto normals = area_normals(mesh);
    const VertexFaces around(mesh);
    const auto bends = vertex_bends(mesh);
    const Vec3d lamp = lamp_of(mesh);
    std::vector<float> lights;
    lights.reserve(3 * mesh.triangles.size());
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
    {
        const Vec3d own = normalized(normals[face]);
        for (const std::uint32_t v : mesh.triangles[face])
        {
            Vec3d sum;
            for (std::size_t i = around.begin[v]; i < around.begin[v + 1]; ++i)
                if (const Vec3d other = normals[around.faces[i]]; dot(normalized(other), own) >= crease_cosine)
                    sum += other;
            const double facing = dot(normalized(sum), normalized(lamp - position(mesh, v)));
            const double bend = std::clamp(2 * bends[v], -1.0, 1.0);
            lights.push_back(static_cast<float>(light_of(middle_lightness + lamp_range * facing + bend_range * bend)));
        }
    }
    return lights;
}

}  // namespace from_model
