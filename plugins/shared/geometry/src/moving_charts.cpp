#include "moving_charts.h"

#include <map>

namespace fresco::geometry
{
namespace
{

/// About a face's size, and so large that all faces together touch a few cells each, however large some of them are.
double cell_size(const FlatCharts& flat)
{
    double edges = 0;
    double boxes = 0;
    for (std::size_t c = 0; c < flat.corners.size(); c += 3)
    {
        const auto* t = &flat.corners[c];
        const auto [x_low, x_high] = std::minmax({t[0].x, t[1].x, t[2].x});
        const auto [y_low, y_high] = std::minmax({t[0].y, t[1].y, t[2].y});
        edges += std::max(x_high - x_low, y_high - y_low);
        boxes += (x_high - x_low) * (y_high - y_low);
    }
    const auto faces = std::max(static_cast<double>(flat.chart_of_face.size()), 1.0);
    return std::max({1.5 * edges / faces, std::sqrt(boxes / faces), 1e-9});
}

}  // namespace

MovingCharts::MovingCharts(const Surface& surface, FlatCharts& flat)
    : surface_(surface), flat_(flat), faces_(Partition{flat.chart_of_face, flat.axes}.faces()), cell_m_(cell_size(flat))
{
    cells_.reserve(flat.chart_of_face.size());
    for (std::uint32_t f = 0; f < flat.chart_of_face.size(); ++f)
        enter(f);
}

bool MovingCharts::is_crumb(std::uint32_t chart, const CrumbLimits& limits) const
{
    if (faces_[chart].empty() || faces_[chart].size() > limits.faces)
        return false;
    double area = 0;
    for (const auto f : faces_[chart])
        area += surface_.areas[f];
    return area <= limits.area_m2;
}

std::vector<std::uint32_t> MovingCharts::crumbs(const CrumbLimits& limits) const
{
    std::vector<std::uint32_t> found;
    for (std::uint32_t c = 0; c < faces_.size(); ++c)
        if (is_crumb(c, limits))
            found.push_back(c);
    std::stable_sort(found.begin(), found.end(), [&](auto a, auto b) { return faces_[a].size() < faces_[b].size(); });
    return found;
}

std::vector<std::uint32_t> MovingCharts::neighbors(std::uint32_t chart) const
{
    std::map<std::uint32_t, double> borders;
    for (const auto f : faces_[chart])
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = surface_.neighbors[f][k];
            if (g == none || flat_.chart_of_face[g] == chart || faces_[flat_.chart_of_face[g]].size() < faces_[chart].size())
                continue;
            const auto& t = surface_.mesh.triangles[f];
            borders[flat_.chart_of_face[g]] +=
                static_cast<double>(length(surface_.mesh.positions[t[(k + 1) % 3]] - surface_.mesh.positions[t[k]]));
        }
    std::vector<std::uint32_t> charts;
    charts.reserve(borders.size());
    for (const auto& [other, border] : borders)
        charts.push_back(other);
    std::stable_sort(charts.begin(), charts.end(), [&](auto a, auto b) { return borders[a] > borders[b]; });
    return charts;
}

void MovingCharts::enter(std::uint32_t face)
{
    each_cell(flat_.chart_of_face[face], triangle(face), [&](Key key) { cells_[key].push_back(face); });
}

void MovingCharts::lay(std::uint32_t face, std::uint32_t chart, std::span<const Vec2d, 3> corners)
{
    std::copy(corners.begin(), corners.end(), flat_.corners.begin() + 3 * std::ptrdiff_t{face});
    flat_.chart_of_face[face] = chart;
    flat_.projected[face] = 0;
    enter(face);
}

void MovingCharts::dissolve(std::uint32_t crumb, std::uint32_t chart)
{
    faces_[chart].insert(faces_[chart].end(), faces_[crumb].begin(), faces_[crumb].end());
    flat_.unfolded_faces += faces_[crumb].size();
    faces_[crumb].clear();
}

}  // namespace fresco::geometry
