#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/run_context.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

/// \file The charts of a mesh's texcoords, how they join on the surface, and the face behind each texel of a texture.

namespace fresco::texturing
{

/// Positions and triangles, these on the lowest of the vertices at one position: not cut along the seams of an atlas.
Mesh welded(const Mesh& mesh);

/// V normals that vertices at the same position share, so that they are smooth across seams; 0 where faces cancel or have no
/// area.
std::vector<Vec3f> smooth_normals(const Mesh& mesh);

/// An edge of the surface along which the atlas is cut: the same two points in the texcoords of the faces on both sides.
struct Seam
{
    std::uint32_t first_face = 0;
    std::uint32_t second_face = 0;
    std::array<Vec2f, 2> first;
    std::array<Vec2f, 2> second;
};

/// The charts of a mesh's texcoords and how they join on the surface.
struct Charts
{
    std::vector<std::uint32_t> of_face;  ///< F, counted from 0 in the order of their first faces.
    std::uint32_t count = 0;
    std::vector<Seam> seams;
};

/// Faces whose common edge has the same texcoords on both sides share a chart. Vertices at the same position count as one, so a
/// mesh that was split along its seams is joined again; of three or more faces at an edge each is joined with the next. The mesh
/// needs texcoords.
Charts find_charts(const Mesh& mesh);

/// check_mesh, and that there are texcoords. Throws Error naming `source`, and what to `wire` where it has none.
void check_has_atlas(const Mesh& mesh, std::string_view source, std::string_view wire);

/// Checks what painting in an atlas relies on: every place of the texture shows one place of the surface, and all of the surface
/// has a place there. Throws Error naming `source`, the share of the surface without, and the way out if it is more than a
/// twentieth; warns above a thousandth. Faces laid on others as a mirror image are accepted, and those that are in one place on
/// the surface, too, as duplicates are. Time grows with the faces, plus one pass over at most 2048 x 2048 texels.
/// \pre The mesh has passed check_mesh and has texcoords.
void check_layout(const Mesh& mesh, std::string_view source, RunContext& run);

/// Maps texels to faces. Texel (x, y), row 0 at the top (v = 1), is number y * size + x.
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
/// \pre Texcoords are finite.
TexelFaces find_texel_faces(const Mesh& mesh, const Charts& charts, int size, const Progress& progress);

/// The weights of its face's corners at a covered texel's center: at least 0, and 1 in all.
std::array<double, 3> texel_weights(const Mesh& mesh, const TexelFaces& faces, std::size_t texel);

/// The surface point at a covered texel's center (meters), one in its face near by where the center is outside.
Vec3f texel_position(const Mesh& mesh, const TexelFaces& faces, std::size_t texel);

/// The side of a texel on the surface in meters, by the area of the charts in a texture of `size_px`; 0 if they or the surface
/// have no area. The mesh must have texcoords.
double mean_texel_m(const Mesh& mesh, int size_px);

/// The longest side of the box around the vertices, in meters: those of mesh.in_view are of the whole surface.
double longest_side_m(const Mesh& mesh);
/// The width of brush strokes where nobody says another: 3.5 cm on a surface 3 m long or longer, in proportion on a smaller one,
/// and at least two texels of this size.
double usual_stroke_m(const Mesh& mesh, double texel_m);

/// Pairs of texels that meet across a seam, each in both directions, sorted and unique.
std::vector<std::pair<std::uint32_t, std::uint32_t>> seam_links(const Charts& charts, const TexelFaces& faces);

}  // namespace fresco::texturing
