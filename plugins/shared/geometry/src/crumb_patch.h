#pragma once

#include "moving_charts.h"
#include "relaxation.h"

#include <optional>

namespace fresco::geometry
{

/// A crumb and the faces of a chart around it, to be laid out together.
struct CrumbPatch
{
    FaceList faces;
    FlatPatch shape;             ///< Triangles in the order of the faces.
    std::vector<bool> on_chart;  ///< Per vertex: it has a place in the chart already.
};

/// Makes patches; keeps room for them between calls. Refers to the charts, which must outlive it.
class PatchMaker
{
  public:
    explicit PatchMaker(const MovingCharts& charts) : charts_(charts), place_(charts.surface().areas.size(), none) {}

    /// The crumb and what of the chart is within `steps` faces of it. The crumb's edges to the chart and inside are closed; the
    /// chart's own cuts stay open. Vertices that further faces of the chart hang on are not movable. The crumb's are unrolled: as
    /// if its faces were turned about their edges into the plane. Nothing if the crumb ties places of the chart together that
    /// must stay apart.
    std::optional<CrumbPatch> make(std::uint32_t crumb, std::uint32_t chart, int steps);

  private:
    void collect(std::uint32_t crumb, std::uint32_t chart, int steps, FaceList& patch);
    std::optional<CrumbPatch> assemble(const FaceList& patch, std::uint32_t chart) const;
    bool together(std::uint32_t f, std::uint32_t g, std::uint32_t vertex) const;

    const MovingCharts& charts_;
    std::vector<std::uint32_t> place_;  ///< Of every face in the patch, or `none`.
};

/// Draws the crumb's vertices into the middle of their neighbors: a beginning for crumbs that the chart surrounds.
void contract(CrumbPatch& patch);

}  // namespace fresco::geometry
