#include <fresco/geometry/charts.h>
#include <fresco/parallel.h>

#include <cmath>
#include <numbers>
#include <queue>

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

double cosine_of(double degrees)
{
    return std::cos(degrees * std::numbers::pi / 180);
}

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
    std::vector<double> area_of_cell(6 * 64, 0.0);
    std::vector<std::uint32_t> order;
    for (std::uint32_t f = 0; f < normals.size(); ++f)
        if (partition.chart_of_face[f] == none)
        {
            area_of_cell[direction_cell(normals[f])] += surface.areas[f];
            order.push_back(f);
        }
    std::stable_sort(order.begin(), order.end(),
                     [&](auto a, auto b)
                     { return area_of_cell[direction_cell(normals[a])] > area_of_cell[direction_cell(normals[b])]; });
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
        parallel_for(current.size(), 1u << 14, progress.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         for (std::size_t f = begin; f < end; ++f)
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
                         }
                     });
        current.swap(next);
    }
    return current;
}

void grow_charts(const Surface& surface, const std::vector<Vec3d>& normals, double angle_limit_deg, Partition& partition,
                 const Progress& progress)
{
    const double limit = 1 - cosine_of(angle_limit_deg);
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

void settle_borders(const Surface& surface, const std::vector<Vec3d>& normals, double angle_limit_deg, Partition& partition,
                    const Progress& progress)
{
    const double limit = 1 - cosine_of(angle_limit_deg);
    const auto lists = partition.faces();
    Queue queue;
    for (std::uint32_t c = 0; c < lists.size(); ++c)
    {
        if (lists[c].size() < small_chart_faces)
            continue;
        const auto best = *std::min_element(lists[c].begin(), lists[c].end(),
                                            [&](auto a, auto b)
                                            { return dot(normals[a], partition.axes[c]) > dot(normals[b], partition.axes[c]); });
        queue.push({0, best, c});
    }
    std::vector<std::uint32_t> owner(normals.size(), none);
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
            if (g != none && owner[g] == none)
            {
                const bool flat = dot(normals[g], normals[g]) == 0;
                queue.push({flat ? 0 : 1 - dot(normals[g], partition.axes[next.chart]), g, next.chart});
            }
    }
    Partition settled;
    settled.chart_of_face.assign(owner.size(), none);
    std::vector<std::uint32_t> number(lists.size(), none);
    for (std::size_t f = 0; f < owner.size(); ++f)
        if (const auto c = owner[f]; c != none)
        {
            if (number[c] == none)
            {
                number[c] = static_cast<std::uint32_t>(settled.axes.size());
                settled.axes.push_back(dot(sums[c], sums[c]) > 0 ? normalized(sums[c]) : partition.axes[c]);
            }
            settled.chart_of_face[f] = number[c];
        }
    partition = std::move(settled);
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

}  // namespace fresco::geometry
