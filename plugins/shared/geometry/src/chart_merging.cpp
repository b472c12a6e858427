#include "moving_charts.h"

#include <fresco/geometry/charts.h>

#include <cmath>
#include <map>
#include <numbers>

namespace fresco::geometry
{

namespace
{

constexpr int merging_rounds = 4;

struct Link
{
    std::uint32_t chart;
    double length_m;
};

/// Every chart's neighbors, longest common border first.
std::vector<std::vector<Link>> chart_links(const Surface& surface, const Partition& partition)
{
    std::vector<std::map<std::uint32_t, double>> lengths(partition.axes.size());
    for (std::size_t f = 0; f < surface.neighbors.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = surface.neighbors[f][k];
            if (g == none || partition.chart_of_face[g] == partition.chart_of_face[f])
                continue;
            const auto& t = surface.mesh.triangles[f];
            const auto edge = surface.mesh.positions[t[(k + 1) % 3]] - surface.mesh.positions[t[k]];
            lengths[partition.chart_of_face[f]][partition.chart_of_face[g]] += static_cast<double>(length(edge));
        }
    std::vector<std::vector<Link>> links(lengths.size());
    for (std::size_t c = 0; c < lengths.size(); ++c)
    {
        for (const auto& [chart, length_m] : lengths[c])
            links[c].push_back({chart, length_m});
        std::stable_sort(links[c].begin(), links[c].end(), [](const Link& a, const Link& b) { return a.length_m > b.length_m; });
    }
    return links;
}

bool all_within(const std::vector<std::uint32_t>& faces, const std::vector<Vec3d>& normals, Vec3d axis, double cosine)
{
    return std::all_of(faces.begin(), faces.end(),
                       [&](auto f) { return dot(normals[f], normals[f]) == 0 || dot(normals[f], axis) >= cosine; });
}

void renumber(Partition& partition, const std::vector<std::uint32_t>& target)
{
    std::vector<std::uint32_t> number(partition.axes.size(), none);
    std::vector<Vec3d> axes;
    for (auto& c : partition.chart_of_face)
    {
        c = target[c];
        if (number[c] == none)
        {
            number[c] = static_cast<std::uint32_t>(axes.size());
            axes.push_back(partition.axes[c]);
        }
        c = number[c];
    }
    partition.axes = std::move(axes);
}

/// One round: every chart joins at most once, and none joins a chart that has itself moved. Returns how many joined.
std::size_t merge_once(const Surface& surface, const std::vector<Vec3d>& normals, const ChartOptions& options,
                       Partition& partition)
{
    const double angle_cosine = std::cos(options.angle_limit_deg * std::numbers::pi / 180);
    const double merge_cosine = std::cos(options.merge_limit_deg * std::numbers::pi / 180);
    const auto links = chart_links(surface, partition);
    const auto lists = partition.faces();
    std::vector<double> area(lists.size(), 0.0);
    for (std::size_t c = 0; c < lists.size(); ++c)
        for (const auto f : lists[c])
            area[c] += surface.areas[f];
    std::vector<std::uint32_t> order(lists.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return area[a] < area[b]; });

    std::vector<std::uint32_t> target(lists.size());
    std::iota(target.begin(), target.end(), 0u);
    std::vector<bool> taken(lists.size(), false);
    std::size_t joined = 0;
    for (const auto c : order)
    {
        if (taken[c])
            continue;
        for (const auto& link : links[c])
        {
            const auto into = link.chart;
            if (target[into] != into || std::pair(area[into], into) < std::pair(area[c], c))
                continue;
            const auto axis = partition.axes[into];
            if (all_within(lists[c], normals, axis, angle_cosine) ||
                (lists[c].size() <= crumb_faces && all_within(lists[c], surface.normals, axis, merge_cosine)))
            {
                target[c] = into;
                taken[into] = true;
                ++joined;
                break;
            }
        }
    }
    renumber(partition, target);
    return joined;
}

}  // namespace

void merge_charts(const Surface& surface, const std::vector<Vec3d>& normals, const ChartOptions& options, Partition& partition,
                  const Progress& progress)
{
    for (int round = 0; round < merging_rounds; ++round)
    {
        progress.check_canceled();
        if (merge_once(surface, normals, options, partition) == 0)
            break;
    }
}

}  // namespace fresco::geometry
