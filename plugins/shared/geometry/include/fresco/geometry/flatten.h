#pragma once

#include <fresco/geometry/charts.h>
#include <fresco/geometry/topology.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

/// \file Charts laid flat, each in its own plane, all at one scale, and the faces of a flat chart that lie on each other.

namespace fresco::geometry
{

/// Corner k of face f of a flattened mesh is at corners[3 * f + k].
using Corners = std::vector<Vec2d>;

/// The axis-parallel box of points that are added.
struct FlatBox
{
    Vec2d low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Vec2d high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    FlatBox() = default;
    explicit FlatBox(std::span<const Vec2d> points)
    {
        for (const Vec2d p : points)
            add(p);
    }
    void add(Vec2d p)
    {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    Vec2d size() const { return high - low; }
};

/// How deep two triangles reach into each other: the smallest shift that parts them (0 if they only touch or are apart). Any
/// orientation; a triangle without area has depth 0 with everything it does not cross.
double overlap_depth(std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b);

/// All pairs (first < second, ascending) of the listed faces whose overlap is deeper than `tolerance`, by a grid of cells.
std::vector<std::pair<std::uint32_t, std::uint32_t>> find_overlaps(const Corners& corners, std::span<const std::uint32_t> faces,
                                                                   double tolerance);

/// A surface cut into flat pieces. Within a chart no two faces overlap, and every face with area lies with its outside up.
struct FlatCharts
{
    std::vector<std::uint32_t> chart_of_face;  ///< F
    Corners corners;                           ///< 3F, meters, in the plane of the face's chart.
    std::vector<Vec3d> axes;                   ///< One per chart: the direction it was projected along.
    std::vector<std::uint8_t> projected;       ///< F: 1 if the corners are the plain projection, 0 if they were moved.
    std::size_t unfolded_faces = 0;            ///< Crumbs that went into a chart beside them.

    /// The faces of every chart, ascending.
    std::vector<std::vector<std::uint32_t>> faces() const { return Partition{chart_of_face, axes}.faces(); }
};

struct FlattenOptions
{
    ChartOptions charts;
    double texel_m;  ///< The size of a texel to expect: crumbs are small in texels, and depths below a thousandth are rounding.

    double tolerance_m() const { return 1e-3 * texel_m; }
};

/// Projects every chart along its mean normal. Faces that turn away from it by more than merge_limit_deg, and faces that would
/// lie on others of their chart, leave it and make charts of their own. Crumbs of few faces then go into a chart beside them,
/// unless merge_limit_deg is angle_limit_deg. Deterministic. Throws Canceled.
FlatCharts project_charts(const Surface& surface, const Partition& partition, const FlattenOptions& options, Progress& progress);

/// Lays charts of a few faces and texels beside a neighbor, turned about an edge that both share and scaled by at most 1.25 to
/// fit it, where nothing lies there yet. Nothing overlaps afterward that did not before. Returns how many charts went; their
/// numbers stay unused.
std::size_t attach_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress);

/// Lays charts of a few faces and texels into a neighbor with all edges that both share: the chart's faces nearby give way, by a
/// relaxation that lets none fold over (Garanzha et al. 2021), and keep at least a twentieth of their area. Nothing overlaps
/// afterward that did not before. Returns how many charts went; their numbers stay unused.
std::size_t join_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress);

/// Connected subset of one chart's faces without overlaps, by growing from its largest clean part; the faces that turn least from
/// the axis come first. Equals `faces` if nothing overlaps and they are connected.
std::vector<std::uint32_t> injective_part(const Surface& surface, const Corners& corners, const std::vector<std::uint32_t>& faces,
                                          Vec3d axis, double tolerance);

}  // namespace fresco::geometry
