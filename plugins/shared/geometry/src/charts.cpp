#include <fresco/geometry/charts.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <queue>
#include <utility>

namespace fresco::geometry
{

namespace
{

constexpr int smoothing_rounds = 10;
/// Neighbors that turn by more than this (cosine) do not smooth each other.
constexpr double crease_cosine = 0.3;
/// Charts of fewer faces do not hold their border against larger ones.
constexpr std::size_t small_chart_faces = 32;
constexpr std::size_t faces_between_checks = 1u << 16;

struct Candidate
{
    double deviation;  ///< 1 - cosine to the axis.
    std::uint32_t face;
    std::uint32_t chart;
    friend bool operator<(const Candidate& a, const Candidate& b)
    {
        return std::tie(b.deviation, b.face, b.chart) < std::tie(a.deviation, a.face, a.chart);
    }
};
using Queue = std::priority_queue<Candidate>;

/// A cell of a cube around the directions, 8 x 8 per side.
std::size_t direction_cell(Vec3d n)
{
    constexpr int side = 8;
    const double coordinates[3] = {n.x, n.y, n.z};
    std::size_t main = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(coordinates[k]) > std::abs(coordinates[main]))
            main = k;
    const double scale = std::abs(coordinates[main]);
    const auto bin = [&](double v) { return std::min(side - 1, static_cast<int>((v / scale + 1) / 2 * side)); };
    const int u = scale > 0 ? bin(coordinates[(main + 1) % 3]) : 0;
    const int v = scale > 0 ? bin(coordinates[(main + 2) % 3]) : 0;
    return (main * 2 + (coordinates[main] < 0 ? 1 : 0)) * side * side + static_cast<std::size_t>(v * side + u);
}

std::vector<std::uint32_t> seed_order(const Surface& surface, const std::vector<Vec3d>& normals, const Partition& partition)
{
    std::vector<double> area_of_cell(std::size_t{6} * 64, 0.0);
    std::vector<std::uint32_t> order;
    std::vector<std::size_t> cells(normals.size());
    for (std::uint32_t f = 0; f < normals.size(); ++f)
        if (partition.chart_of_face[f] == none)
        {
            cells[f] = direction_cell(normals[f]);
            area_of_cell[cells[f]] += surface.areas[f];
            order.push_back(f);
        }
    std::ranges::stable_sort(order, std::greater<>(), [&](auto f) { return area_of_cell[cells[f]]; });
    return order;
}

}  // namespace

Surface::Surface(const Mesh& of)
    : mesh(of), neighbors(face_neighbors(of.triangles, of.positions.size())), areas(of.triangles.size()),
      normals(of.triangles.size())
{
    for (std::size_t f = 0; f < areas.size(); ++f)
    {
        const auto twice = area_vector(of, f);
        areas[f] = 0.5 * length(twice);
        normals[f] = normalized(twice);
    }
}

std::vector<std::vector<std::uint32_t>> Partition::faces() const
{
    std::vector<std::vector<std::uint32_t>> lists(axes.size());
    for (std::uint32_t f = 0; f < chart_of_face.size(); ++f)
        if (chart_of_face[f] != none)
            lists[chart_of_face[f]].push_back(f);
    return lists;
}

std::vector<Vec3d> smoothed_normals(const Surface& surface, const Progress& progress)
{
    auto current = surface.normals;
    std::vector<Vec3d> next(current.size());
    for (int round = 0; round < smoothing_rounds; ++round)
    {
        progress.check_canceled();
        parallel_items(current.size(), 1u << 14, progress,
                       [&](std::size_t f)
                       {
                           Vec3d sum = current[f] * surface.areas[f];
                           const bool known = dot(current[f], current[f]) > 0;
                           for (const auto g : surface.neighbors[f])
                               if (g != none)
                               {
                                   const double agreement = known ? dot(current[f], current[g]) - crease_cosine : 1.0;
                                   sum += current[g] * (surface.areas[g] * std::max(agreement, 0.0));
                               }
                           next[f] = normalized(sum);
                       });
        current.swap(next);
    }
    return current;
}

void grow_charts(const Surface& surface, const std::vector<Vec3d>& normals, double angle_limit_deg, Partition& partition,
                 const Progress& progress)
{
    const double limit = 1 - numerics::cosine_deg(angle_limit_deg);
    const auto order = seed_order(surface, normals, partition);
    std::size_t visited = 0;
    for (const auto seed : order)
    {
        if (partition.chart_of_face[seed] != none)
            continue;
        const auto chart = static_cast<std::uint32_t>(partition.axes.size());
        Vec3d sum{};
        Vec3d axis = normals[seed];
        Queue queue;
        queue.push({0, seed, chart});
        while (!queue.empty())
        {
            const auto face = queue.top().face;
            queue.pop();
            if (++visited % faces_between_checks == 0)
                progress.check_canceled();
            const bool flat = dot(normals[face], normals[face]) == 0;
            if (partition.chart_of_face[face] != none || (!flat && 1 - dot(normals[face], axis) > limit))
                continue;
            partition.chart_of_face[face] = chart;
            sum += normals[face] * surface.areas[face];
            if (dot(sum, sum) > 0)
                axis = normalized(sum);
            for (const auto g : surface.neighbors[face])
                if (g != none && partition.chart_of_face[g] == none)
                    queue.push({1 - dot(normals[g], axis), g, chart});
        }
        partition.axes.push_back(axis);
    }
}

namespace
{

/// Moves the borders between charts to where the normals are equally far from both axes, and frees the faces of small charts that
/// a larger one can take. What no chart takes is `none` afterward.
void settle_borders(const Surface& surface, const std::vector<Vec3d>& normals, double angle_limit_deg, Partition& partition,
                    const Progress& progress)
{
    const double limit = 1 - numerics::cosine_deg(angle_limit_deg);
    const auto lists = partition.faces();
    Queue queue;
    for (std::uint32_t c = 0; c < lists.size(); ++c)
    {
        if (lists[c].size() < small_chart_faces)
            continue;
        const auto best = *std::ranges::max_element(lists[c], {}, [&](auto f) { return dot(normals[f], partition.axes[c]); });
        queue.push({0, best, c});
    }
    std::vector<std::uint32_t> owner(normals.size(), none);
    std::vector<std::uint32_t> offered(normals.size(), none);  // The chart that last waits for a face; once is enough.
    std::vector<Vec3d> sums(lists.size());
    for (std::size_t visited = 0; !queue.empty(); ++visited)
    {
        if (visited % faces_between_checks == 0)
            progress.check_canceled();
        const auto next = queue.top();
        queue.pop();
        if (owner[next.face] != none || next.deviation > limit)
            continue;
        owner[next.face] = next.chart;
        sums[next.chart] += normals[next.face] * surface.areas[next.face];
        for (const auto g : surface.neighbors[next.face])
            if (g != none && owner[g] == none && std::exchange(offered[g], next.chart) != next.chart)
            {
                const bool flat = dot(normals[g], normals[g]) == 0;
                queue.push({flat ? 0 : 1 - dot(normals[g], partition.axes[next.chart]), g, next.chart});
            }
    }
    Partition settled;
    for (const auto c : numerics::number_by_first(owner, lists.size()))
        settled.axes.push_back(dot(sums[c], sums[c]) > 0 ? normalized(sums[c]) : partition.axes[c]);
    settled.chart_of_face = std::move(owner);
    partition = std::move(settled);
}

}  // namespace

std::vector<std::uint32_t> charts_beside(const Surface& surface, const std::vector<std::uint32_t>& chart_of_face,
                                         const std::vector<std::uint32_t>& faces)
{
    std::map<std::uint32_t, double> borders;
    for (const auto f : faces)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = surface.neighbors[f][k];
            if (g == none || chart_of_face[g] == chart_of_face[f])
                continue;
            const auto& t = surface.mesh.triangles[f];
            borders[chart_of_face[g]] +=
                static_cast<double>(length(surface.mesh.positions[t[(k + 1) % 3]] - surface.mesh.positions[t[k]]));
        }
    std::vector<std::uint32_t> charts;
    charts.reserve(borders.size());
    for (const auto& [chart, border] : borders)
        charts.push_back(chart);
    std::ranges::stable_sort(charts, std::greater<>(), [&](std::uint32_t chart) { return borders[chart]; });
    return charts;
}

void renumber_charts(std::vector<std::uint32_t>& chart_of_face, std::vector<Vec3d>& axes)
{
    std::vector<Vec3d> remaining;
    for (const auto c : numerics::number_by_first(chart_of_face, axes.size()))
        remaining.push_back(axes[c]);
    axes = std::move(remaining);
}

Partition cut_into_charts(const Surface& surface, const ChartOptions& options, const Progress& progress)
{
    const auto normals = smoothed_normals(surface, progress);
    Partition partition;
    partition.chart_of_face.assign(surface.areas.size(), none);
    grow_charts(surface, normals, options.angle_limit_deg, partition, progress);
    for (int round = 0; round < 2; ++round)
    {
        settle_borders(surface, normals, options.angle_limit_deg, partition, progress);
        grow_charts(surface, normals, options.angle_limit_deg, partition, progress);
    }
    merge_charts(surface, normals, options, partition, progress);
    return partition;
}

namespace
{

constexpr int merging_rounds = 4;

bool all_within(const std::vector<std::uint32_t>& faces, const std::vector<Vec3d>& normals, Vec3d axis, double cosine)
{
    return std::ranges::all_of(faces,
                               [&](auto f) { return dot(normals[f], normals[f]) == 0 || dot(normals[f], axis) >= cosine; });
}

/// One round: every chart joins at most once, and none joins a chart that has itself moved. Returns how many joined.
std::size_t merge_once(const Surface& surface, const std::vector<Vec3d>& normals, const ChartOptions& options,
                       Partition& partition)
{
    const double angle_cosine = numerics::cosine_deg(options.angle_limit_deg);
    const double merge_cosine = numerics::cosine_deg(options.merge_limit_deg);
    const auto lists = partition.faces();
    std::vector<double> area(lists.size(), 0.0);
    for (std::size_t c = 0; c < lists.size(); ++c)
        for (const auto f : lists[c])
            area[c] += surface.areas[f];
    std::vector<std::uint32_t> order(lists.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](auto c) { return area[c]; });

    std::vector<std::uint32_t> target(lists.size());
    std::iota(target.begin(), target.end(), 0u);
    std::vector<bool> taken(lists.size(), false);
    std::size_t joined = 0;
    for (const auto c : order)
    {
        if (taken[c])
            continue;
        for (const auto into : charts_beside(surface, partition.chart_of_face, lists[c]))
        {
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
    for (auto& c : partition.chart_of_face)
        c = target[c];
    renumber_charts(partition.chart_of_face, partition.axes);
    return joined;
}

}  // namespace

void merge_charts(const Surface& surface, const std::vector<Vec3d>& normals, const ChartOptions& options, Partition& partition,
                  const Progress& progress)
{
    for (int round = 0; round < merging_rounds && merge_once(surface, normals, options, partition) > 0; ++round)
        progress.check_canceled();
}

}  // namespace fresco::geometry
