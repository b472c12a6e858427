#pragma once

#include <fresco/geometry/charts.h>

#include <cstdint>
#include <vector>

/// \file Charts as meshes of their own that can be laid flat.

namespace fresco::geometry
{

/// Faces that can be laid flat: a disk, maybe with holes. Where the surface is closed or has handles, vertices are doubled along
/// cuts.
struct Disk
{
    std::vector<Vec3d> points;
    std::vector<Triangle> triangles;  ///< In the order of the faces it was made of.
    std::size_t cut_edges = 0;        ///< Edges inside along which it was cut.
};

/// The faces, which must be connected and ascending, as they are if they have a border and no handle. What has none is cut:
/// joined over a spanning tree of its faces, which gives a disk whatever the shape, and closed again wherever a cut ends
/// freely, save two edges of a closed surface.
Disk cut_to_disk(const Surface& surface, const std::vector<std::uint32_t>& faces);

}  // namespace fresco::geometry
