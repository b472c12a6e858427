#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/progress.h>
#include <fresco/texturing/charts.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace fresco::texturing
{

/// Which face a texel belongs to. Texel (x, y), row 0 at the top (v = 1), is number y * size + x.
struct TexelFaces
{
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    int size = 0;
    std::vector<std::uint32_t> face;  ///< size^2; none in the gutter.
    std::vector<std::uint8_t>
        inside;  ///< size^2; 1 = the chart's own: its center is inside, or the chart holds no center at all.

    bool covered(std::size_t texel) const { return face[texel] != none; }
    /// The texel that holds a texcoord; those on or beyond the border belong to the last one.
    std::size_t at(Vec2f uv) const;
};

/// Every texel that a face touches, however little; where several do, the one that holds the center comes first, then the lower
/// face. Equal for any number of threads. Throws Canceled.
TexelFaces find_texel_faces(const Mesh& mesh, const Charts& charts, int size, const Progress& progress);

/// The weights of its face's corners at a covered texel's center: at least 0, and 1 in all.
std::array<double, 3> texel_weights(const Mesh& mesh, const TexelFaces& faces, std::size_t texel);

/// The surface point at a covered texel's center (meters), one in its face near by where the center is outside.
Vec3f texel_position(const Mesh& mesh, const TexelFaces& faces, std::size_t texel);

}  // namespace fresco::texturing
