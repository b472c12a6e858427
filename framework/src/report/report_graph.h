#pragma once

#include "report/report_model.h"

#include <string>
#include <vector>

namespace fresco::host
{

/// A box of the drawn pipeline: a stage, or a place where a wire passes through a layer.
struct GraphBox
{
    int stage = -1;  ///< Index of the stage; -1: a wire passes.
    int layer = 0;   ///< Longest way from a stage without producers.
    int row = 0;     ///< From the top; no two boxes of a layer share one.
};

struct GraphDrawing
{
    std::vector<GraphBox> boxes;  ///< The stages first, in their order.
    /// Of each wire between two stages (several between the same two are one): the boxes it visits.
    std::vector<std::vector<int>> ways;
    int layers = 0;
    int rows = 0;
};

/// Places the stages from left to right by what they wait for, and in each layer near what they are joined to.
GraphDrawing draw_graph(const std::vector<ReportStage>& stages);

/// The pipeline as an SVG element with states and times.
std::string graph_svg(const std::vector<ReportStage>& stages);

}  // namespace fresco::host
