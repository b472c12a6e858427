#pragma once

#include <fresco/math.h>
#include <fresco/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace fresco::texturing
{

/// V: the lowest index of the vertices at the same position.
std::vector<std::uint32_t> welded_vertices(const Mesh& mesh);

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

}  // namespace fresco::texturing
