#pragma once

#include <fresco/geometry/flatten.h>

#include <cstdint>
#include <vector>

/// A chart as a mesh of its own that is a topological disk: where the chart has holes or handles, vertices are doubled along
/// cuts.
struct Disk
{
    std::vector<fresco::Vec3d> points;
    std::vector<fresco::Triangle> triangles;  ///< In the order of the chart's faces.
    std::size_t cut_edges = 0;                ///< Edges inside the chart along which it was cut.
};

/// Joins the faces over a spanning tree of their neighbourhood, which gives a disk whatever the chart's shape, and closes every
/// cut that ends freely; what stays open are the shortest connections that the tree left between the borders. The faces must be
/// connected.
Disk cut_to_disk(const fresco::geometry::Surface& surface, const std::vector<std::uint32_t>& faces);
