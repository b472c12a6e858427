#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

/// \file How a face lies in space and in its texture, for plugins that go from texel to texel along the surface.

namespace fresco::texturing
{

struct FaceFrame
{
    std::array<Vec2d, 3> corners;  ///< Texels, x to the right and y down.
    std::array<Vec3d, 3> points;
    double area = 0;    ///< Twice the area in the texture, square texels; negative for a mirrored face.
    Vec3d right, down;  ///< Meters per texel; zero for a face without area in the texture.

    FaceFrame() = default;
    /// `size`: texels a side. The mesh must have texcoords.
    FaceFrame(const Mesh& mesh, std::uint32_t face, int size)
    {
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2f uv = mesh.texcoords[3 * std::size_t{face} + i];
            corners[i] = {double{uv.x} * size, (1 - double{uv.y}) * size};
            points[i] = vec_cast<double>(mesh.positions[mesh.triangles[face][i]]);
        }
        const Vec2d a = corners[1] - corners[0], b = corners[2] - corners[0];
        const Vec3d p = points[1] - points[0], q = points[2] - points[0];
        area = cross(a, b);
        if (area == 0)
            return;
        right = (p * b.y - q * a.y) * (1 / area);
        down = (q * a.x - p * b.x) * (1 / area);
    }

    /// Twice the area in space times the normal.
    Vec3d normal() const { return cross(points[1] - points[0], points[2] - points[0]); }
};

/// Barycentric coordinates of `p`: at least 0, clamped to the triangle where it lies outside, and 1 in all.
inline std::array<double, 3> weights_at(const std::array<Vec2d, 3>& c, Vec2d p)
{
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    std::array<double, 3> weights{1, 1, 1};
    if (area != 0)
        weights = {cross(c[1] - p, c[2] - p) / area, cross(c[2] - p, c[0] - p) / area, cross(c[0] - p, c[1] - p) / area};
    double sum = 0;
    for (double& w : weights)
        sum += w = std::max(w, 0.0);
    for (double& w : weights)
        w /= sum;
    return weights;
}

inline Vec3f point_in(const Mesh& mesh, std::uint32_t face, const std::array<double, 3>& weights)
{
    Vec3d point;
    for (std::size_t i = 0; i < 3; ++i)
        point += vec_cast<double>(mesh.positions[mesh.triangles[face][i]]) * weights[i];
    return vec_cast<float>(point);
}

}  // namespace fresco::texturing
