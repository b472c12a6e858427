#pragma once

#include <fresco/math.h>

#include <array>

/// \file What it costs to replace an edge by a point: squared distances to the planes of the faces around, as they are now,
/// without memory of earlier collapses (Lindstrom and Turk, "Fast and memory efficient polygonal simplification", Visualization
/// 1998; Hoppe, "New quadric metric for simplifying meshes with appearance attributes", Visualization 1999, section 5). Points
/// are meters from an origin near the surface.

/// xᵀHx - 2k·x + c.
struct Quadratic
{
    std::array<double, 6> h{};  ///< xx, xy, xz, yy, yz, zz.
    fresco::Vec3d k;
    double c = 0;

    double operator()(fresco::Vec3d x) const;
    void add(const Quadratic& other, double weight = 1);
    double trace() const { return h[0] + h[3] + h[5]; }
};

/// Squared distance to a face's plane, times (twice the area)^1.25: between area, which serves the largest distances, and its
/// square, which serves the mean. Zero for a face without area.
Quadratic plane_error(fresco::Vec3d a, fresco::Vec3d b, fresco::Vec3d c);

/// Squared distance to the line of a border edge, times its squared length.
Quadratic line_error(fresco::Vec3d a, fresco::Vec3d b);

/// A point in place of an edge.
struct Placement
{
    fresco::Vec3d point;
    double cost = 0;  ///< >= 0; infinite where no point near the edge can be found.
};

/// The best point for an edge from u to v: the least of `planes` (the sum over the faces around it) and of `lines` (over the
/// border edges around it; null: none). Where these leave it free, near the middle of the edge.
Placement place(const Quadratic& planes, const Quadratic* lines, fresco::Vec3d u, fresco::Vec3d v);
