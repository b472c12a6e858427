#include "report/report_graph.h"
#include "base/unit_text.h"

#include <fresco/html.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>
#include <utility>

namespace fresco::host
{
namespace
{

constexpr double box_width = 128;
constexpr double box_height = 46;
constexpr double column_px = 172;
constexpr double row_px = 64;
constexpr double margin = 8;

using Edges = std::set<std::pair<int, int>>;

Edges edges_of(const std::vector<ReportStage>& stages)
{
    std::map<std::string, int> numbers;
    for (const ReportStage& stage : stages)
        numbers.emplace(stage.name, static_cast<int>(numbers.size()));
    Edges edges;
    for (const ReportStage& stage : stages)
        for (const ReportInput& input : stage.inputs)
            if (const auto from = numbers.find(input.from_stage); from != numbers.end())
                edges.emplace(from->second, numbers.at(stage.name));
    return edges;
}

/// The mean row of a box's neighbors in the layer before (or behind), or its own where it has none.
double wanted_row(const GraphDrawing& drawing, int box, bool from_left)
{
    double sum = 0;
    int count = 0;
    for (const auto& way : drawing.ways)
        for (std::size_t i = 0; i + 1 < way.size(); ++i)
        {
            const int here = from_left ? way[i + 1] : way[i];
            const int there = from_left ? way[i] : way[i + 1];
            if (here != box)
                continue;
            sum += drawing.boxes[static_cast<std::size_t>(there)].row;
            ++count;
        }
    return count > 0 ? sum / count : drawing.boxes[static_cast<std::size_t>(box)].row;
}

void order_layers(GraphDrawing& drawing)
{
    constexpr int sweeps = 6;
    for (int sweep = 0; sweep < sweeps; ++sweep)
    {
        const bool from_left = sweep % 2 == 0;
        for (int step = 0; step < drawing.layers; ++step)
        {
            const int layer = from_left ? step : drawing.layers - 1 - step;
            std::vector<std::pair<double, int>> order;
            for (int box = 0; box < static_cast<int>(drawing.boxes.size()); ++box)
                if (drawing.boxes[static_cast<std::size_t>(box)].layer == layer)
                    order.emplace_back(wanted_row(drawing, box, from_left), box);
            std::ranges::stable_sort(order, {}, [](const auto& entry) { return entry.first; });
            for (std::size_t row = 0; row < order.size(); ++row)
                drawing.boxes[static_cast<std::size_t>(order[row].second)].row = static_cast<int>(row);
        }
    }
}

std::string state_class(const ReportStage& stage)
{
    std::string name = stage.state;
    std::ranges::replace(name, ' ', '-');
    return name;
}

std::string state_text(const ReportStage& stage)
{
    if (stage.state == "ran")
        return duration_text(stage.seconds);
    if (stage.state == "stored" || stage.state == "not needed")
        return "stored" + (stage.seconds > 0 ? " (" + duration_text(stage.seconds) + ")" : std::string());
    return stage.state;
}

struct Place
{
    double x = 0;
    double y = 0;
};

Place place_of(const GraphBox& box, const std::vector<int>& heights, int rows)
{
    // Layers with fewer boxes stand in the middle.
    const double top = (rows - heights[static_cast<std::size_t>(box.layer)]) * row_px / 2;
    return {margin + box.layer * column_px, margin + top + box.row * row_px};
}

std::string shortened(const std::string& text, std::size_t most)
{
    return text.size() <= most ? text : text.substr(0, most - 1) + "…";
}

}  // namespace

GraphDrawing draw_graph(const std::vector<ReportStage>& stages)
{
    const Edges edges = edges_of(stages);
    GraphDrawing drawing;
    drawing.boxes.resize(stages.size());
    for (std::size_t i = 0; i < stages.size(); ++i)
        drawing.boxes[i].stage = static_cast<int>(i);
    // Stages are in a topological order: one pass in the order of what is waited for. Edges are sorted by their beginning.
    for (const auto& [from, to] : edges)
        drawing.boxes[static_cast<std::size_t>(to)].layer =
            std::max(drawing.boxes[static_cast<std::size_t>(to)].layer, drawing.boxes[static_cast<std::size_t>(from)].layer + 1);
    for (const auto& [from, to] : edges)
    {
        std::vector<int> way{from};
        for (int layer = drawing.boxes[static_cast<std::size_t>(from)].layer + 1;
             layer < drawing.boxes[static_cast<std::size_t>(to)].layer; ++layer)
        {
            way.push_back(static_cast<int>(drawing.boxes.size()));
            drawing.boxes.push_back({-1, layer, 0});
        }
        way.push_back(to);
        drawing.ways.push_back(std::move(way));
    }
    std::map<int, int> heights;
    for (GraphBox& box : drawing.boxes)
    {
        box.row = heights[box.layer]++;
        drawing.layers = std::max(drawing.layers, box.layer + 1);
        drawing.rows = std::max(drawing.rows, heights[box.layer]);
    }
    order_layers(drawing);
    return drawing;
}

std::string graph_svg(const std::vector<ReportStage>& stages)
{
    const GraphDrawing drawing = draw_graph(stages);
    std::vector<int> heights(static_cast<std::size_t>(drawing.layers), 0);
    for (const GraphBox& box : drawing.boxes)
        heights[static_cast<std::size_t>(box.layer)] = std::max(heights[static_cast<std::size_t>(box.layer)], box.row + 1);
    const double width = 2 * margin + std::max(0, drawing.layers - 1) * column_px + box_width;
    const double height = 2 * margin + std::max(0, drawing.rows - 1) * row_px + box_height;
    std::string svg =
        fmt::format("<svg class=\"graph\" viewBox=\"0 0 {0:.0f} {1:.0f}\" style=\"max-width:{0:.0f}px\" role=\"img\" "
                    "aria-label=\"The pipeline's stages and how they are joined\">\n",
                    width, height);
    for (const auto& way : drawing.ways)
    {
        std::string path;
        for (std::size_t i = 0; i + 1 < way.size(); ++i)
        {
            const Place from = place_of(drawing.boxes[static_cast<std::size_t>(way[i])], heights, drawing.rows);
            const Place to = place_of(drawing.boxes[static_cast<std::size_t>(way[i + 1])], heights, drawing.rows);
            const double y0 = from.y + box_height / 2;
            const double y1 = to.y + box_height / 2;
            const double x0 = from.x + box_width;
            const double bend = (column_px - box_width) / 2;
            if (i == 0)
                path += fmt::format("M{:.1f} {:.1f}", x0, y0);
            else
                path += fmt::format("H{:.1f}", x0);
            path += fmt::format("C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}", x0 + bend, y0, to.x - bend, y1, to.x, y1);
        }
        svg += "<path class=\"wire\" d=\"" + path + "\"/>\n";
    }
    for (std::size_t i = 0; i < stages.size(); ++i)
    {
        const ReportStage& stage = stages[i];
        const Place at = place_of(drawing.boxes[i], heights, drawing.rows);
        svg += fmt::format("<a href=\"#stage-{}\"><g class=\"stage {}\" transform=\"translate({:.1f} {:.1f})\"><title>{}</title>"
                           "<rect width=\"{:.0f}\" height=\"{:.0f}\" rx=\"6\"/><text x=\"9\" y=\"18\" class=\"name\">{}</text>"
                           "<text x=\"9\" y=\"35\">{}</text></g></a>\n",
                           i, state_class(stage), at.x, at.y, html_escaped(stage.name + ": " + stage.type + "\n" + stage.help),
                           box_width, box_height, html_escaped(shortened(stage.name, 17)),
                           html_escaped(shortened(state_text(stage), 22)));
    }
    return svg + "</svg>\n";
}

}  // namespace fresco::host
