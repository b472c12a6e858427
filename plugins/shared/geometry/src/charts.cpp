#include <fresco/geometry/charts.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <queue>
#include <set>

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
    std::vector<double> area_of_cell(6 * 64, 0.0);
    std::vector<std::uint32_t> order;
    for (std::uint32_t f = 0; f < normals.size(); ++f)
        if (partition.chart_of_face[f] == none)
        {
            area_of_cell[direction_cell(normals[f])] += surface.areas[f];
            order.push_back(f);
        }
    std::ranges::stable_sort(order, std::greater<>(), [&](auto f) { return area_of_cell[direction_cell(normals[f])]; });
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

namespace
{

/// One chart's edges, by place in its list of faces: edge k of face i is half 3 i + k.
class Cutter
{
  public:
    Cutter(const Surface& surface, const std::vector<std::uint32_t>& faces)
        : surface_(surface), faces_(faces), mate_(3 * faces.size(), none), joined_(3 * faces.size(), false)
    {
        for (std::uint32_t i = 0; i < faces.size(); ++i)
            for (std::uint32_t k = 0; k < 3; ++k)
            {
                vertices_.push_back(surface.mesh.triangles[faces[i]][k]);
                const auto j = place_of(faces, surface.neighbors[faces[i]][k]);
                if (j == none)
                    continue;
                for (std::uint32_t m = 0; m < 3; ++m)
                    if (corner(3 * j + m) == end(3 * i + k) && end(3 * j + m) == corner(3 * i + k))
                        mate_[3 * i + k] = 3 * j + m;
            }
        std::sort(vertices_.begin(), vertices_.end());
        vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    }

    void join_all()
    {
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            joined_[h] = mate_[h] != none;
    }

    /// By Euler's number: 2 - 2 x handles - closed border lines.
    bool is_disk_with_holes()
    {
        numerics::DisjointSets corners(mate_.size());
        std::size_t inner = 0;
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (mate_[h] != none)
            {
                corners.join(h, next(mate_[h]));
                ++inner;
            }
        numerics::DisjointSets lines(mate_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (mate_[h] == none)
                lines.join(corners.find(h), corners.find(next(h)));
        std::set<std::uint32_t> borders;
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (mate_[h] == none)
                borders.insert(lines.find(corners.find(h)));
        const std::size_t edges = mate_.size() - inner / 2;
        return !borders.empty() && corners.count() + faces_.size() + borders.size() == edges + 2;
    }

    void join_tree()
    {
        std::vector<bool> reached(faces_.size(), false);
        std::deque<std::uint32_t> front{0};
        reached[0] = true;
        while (!front.empty())
        {
            const auto i = front.front();
            front.pop_front();
            for (auto h = 3 * i; h < 3 * i + 3; ++h)
                if (mate_[h] != none && !reached[mate_[h] / 3])
                {
                    reached[mate_[h] / 3] = true;
                    join(h);
                    front.push_back(mate_[h] / 3);
                }
        }
    }

    /// A cut that ends in a vertex with no other open edge separates nothing. Of a closed surface two edges stay open.
    void close_free_cuts()
    {
        std::vector<std::vector<std::uint32_t>> open(vertices_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
            if (!joined_[h] && (mate_[h] == none || h < mate_[h]))
                for (const auto v : {place(corner(h)), place(end(h))})
                    open[v].push_back(h);
        const bool closed = std::find(mate_.begin(), mate_.end(), none) == mate_.end();
        auto cuts = std::count(joined_.begin(), joined_.end(), false) / 2;
        std::deque<std::size_t> ends(open.size());
        std::iota(ends.begin(), ends.end(), std::size_t{0});
        while (!ends.empty())
        {
            const auto v = ends.front();
            ends.pop_front();
            if (open[v].size() != 1 || mate_[open[v].front()] == none || (closed && cuts == 2))
                continue;
            const auto h = open[v].front();
            join(h);
            --cuts;
            for (const auto w : {place(corner(h)), place(end(h))})
            {
                std::erase(open[w], h);
                ends.push_back(w);
            }
        }
    }

    Disk take() const
    {
        Disk disk;
        numerics::DisjointSets corners(mate_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
        {
            if (joined_[h])
                corners.join(h, next(mate_[h]));
            else if (mate_[h] != none && h < mate_[h])
                ++disk.cut_edges;
        }
        std::vector<std::uint32_t> index(mate_.size(), none);
        disk.triangles.resize(faces_.size());
        for (std::uint32_t h = 0; h < mate_.size(); ++h)
        {
            auto& v = index[corners.find(h)];
            if (v == none)
            {
                v = static_cast<std::uint32_t>(disk.points.size());
                disk.points.push_back(vec_cast<double>(surface_.mesh.positions[corner(h)]));
            }
            disk.triangles[h / 3][h % 3] = v;
        }
        return disk;
    }

  private:
    static std::uint32_t next(std::uint32_t half) { return half / 3 * 3 + (half % 3 + 1) % 3; }
    std::uint32_t corner(std::uint32_t half) const { return surface_.mesh.triangles[faces_[half / 3]][half % 3]; }
    std::uint32_t end(std::uint32_t half) const { return corner(next(half)); }
    std::size_t place(std::uint32_t vertex) const { return place_of(vertices_, vertex); }
    void join(std::uint32_t half) { joined_[half] = joined_[mate_[half]] = true; }

    const Surface& surface_;
    const std::vector<std::uint32_t>& faces_;
    std::vector<std::uint32_t> vertices_;
    std::vector<std::uint32_t> mate_;
    std::vector<bool> joined_;
};

}  // namespace

Disk cut_to_disk(const Surface& surface, const std::vector<std::uint32_t>& faces)
{
    Cutter cutter(surface, faces);
    if (cutter.is_disk_with_holes())
        cutter.join_all();
    else
    {
        cutter.join_tree();
        cutter.close_free_cuts();
    }
    return cutter.take();
}

}  // namespace fresco::geometry
