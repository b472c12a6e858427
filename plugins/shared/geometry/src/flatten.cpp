#include <fresco/geometry/flatten.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>

namespace fresco::geometry
{

namespace
{

std::span<const Vec2d, 3> triangle(const Corners& corners, std::uint32_t face)
{
    return std::span<const Vec2d, 3>(corners.data() + 3 * static_cast<std::size_t>(face), 3);
}

/// Overlap of the shadows on the normals of a's edges; 0 as soon as one separates.
double depth_along_edges(std::span<const Vec2d, 3> of, std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b)
{
    double depth = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto edge = of[(k + 1) % 3] - of[k];
        if (edge == Vec2d{})
            continue;
        const Vec2d axis{-edge.y, edge.x};
        const auto shadow = [&](std::span<const Vec2d, 3> t)
        {
            const double s[3] = {dot(axis, t[0]), dot(axis, t[1]), dot(axis, t[2])};
            return std::pair(std::min({s[0], s[1], s[2]}), std::max({s[0], s[1], s[2]}));
        };
        const auto [a_low, a_high] = shadow(a);
        const auto [b_low, b_high] = shadow(b);
        // Most triangles are apart, which shows before a root is needed.
        const double along = std::min(a_high - b_low, b_high - a_low);
        if (along <= 0)
            return 0;
        depth = std::min(depth, along / length(edge));
    }
    return depth;
}

/// Faces by the cells of a square grid that their boxes touch.
struct Grid
{
    FlatBox bounds;
    double cell = 1;
    std::size_t width = 1;
    std::size_t height = 1;

    std::size_t column(double x) const { return bin(x - bounds.low.x, width); }
    std::size_t row(double y) const { return bin(y - bounds.low.y, height); }

  private:
    std::size_t bin(double offset, std::size_t count) const
    {
        return std::min(count - 1, static_cast<std::size_t>(std::max(offset / cell, 0.0)));
    }
};

Grid make_grid(const std::vector<FlatBox>& boxes)
{
    Grid grid;
    double sizes = 0;
    for (const auto& box : boxes)
    {
        grid.bounds.add(box.low);
        grid.bounds.add(box.high);
        sizes += std::max(box.size().x, box.size().y);
    }
    const auto extent = grid.bounds.size();
    // Cells of a mean face's size, but no more cells than twice the faces.
    grid.cell = std::max({sizes / static_cast<double>(boxes.size()),
                          std::sqrt(extent.x * extent.y / (2.0 * static_cast<double>(boxes.size()))),
                          std::max(extent.x, extent.y) / (2.0 * static_cast<double>(boxes.size())), 1e-300});
    grid.width = static_cast<std::size_t>(extent.x / grid.cell) + 1;
    grid.height = static_cast<std::size_t>(extent.y / grid.cell) + 1;
    return grid;
}

}  // namespace

double overlap_depth(std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b)
{
    const double first = depth_along_edges(a, a, b);
    const double depth = first > 0 ? std::min(first, depth_along_edges(b, a, b)) : 0;
    return std::isfinite(depth) ? depth : 0;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> find_overlaps(const Corners& corners, std::span<const std::uint32_t> faces,
                                                                   double tolerance)
{
    if (faces.size() < 2)
        return {};
    std::vector<FlatBox> boxes;
    for (const auto face : faces)
        boxes.emplace_back(triangle(corners, face));
    const auto grid = make_grid(boxes);

    const numerics::Buckets cells(grid.width * grid.height,
                                  [&](const auto& add)
                                  {
                                      for (std::uint32_t i = 0; i < boxes.size(); ++i)
                                          for (auto y = grid.row(boxes[i].low.y); y <= grid.row(boxes[i].high.y); ++y)
                                              for (auto x = grid.column(boxes[i].low.x); x <= grid.column(boxes[i].high.x); ++x)
                                                  add(y * grid.width + x, i);
                                  });

    std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
    for (std::size_t cell = 0; cell < cells.count(); ++cell)
        for (auto i = cells[cell].begin(); i != cells[cell].end(); ++i)
            for (auto j = i + 1; j != cells[cell].end(); ++j)
            {
                const auto& a = boxes[*i];
                const auto& b = boxes[*j];
                const Vec2d low{std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y)};
                if (low.x >= std::min(a.high.x, b.high.x) || low.y >= std::min(a.high.y, b.high.y))
                    continue;
                // Only the cell with the corner of the common box compares the two.
                if (grid.row(low.y) * grid.width + grid.column(low.x) != cell)
                    continue;
                const auto fa = faces[*i];
                const auto fb = faces[*j];
                if (overlap_depth(triangle(corners, fa), triangle(corners, fb)) > tolerance)
                    found.emplace_back(std::min(fa, fb), std::max(fa, fb));
            }
    std::sort(found.begin(), found.end());
    return found;
}

namespace
{

/// The place where the largest connected part without conflicts begins; if every face has conflicts, the largest face.
std::uint32_t best_seed(const Surface& surface, const std::vector<std::uint32_t>& faces,
                        const std::vector<std::array<std::uint32_t, 3>>& around, const std::vector<bool>& clean)
{
    numerics::DisjointSets parts(faces.size());
    for (std::uint32_t i = 0; i < faces.size(); ++i)
        for (const auto j : around[i])
            if (j != none && clean[i] && clean[j])
                parts.join(i, j);
    std::vector<double> area(faces.size(), 0.0);
    const bool any_clean = std::ranges::find(clean, true) != clean.end();
    for (std::uint32_t i = 0; i < faces.size(); ++i)
        if (clean[i] || !any_clean)
            area[parts.find(i)] += surface.areas[faces[i]];
        else
            area[i] = -1;
    return static_cast<std::uint32_t>(std::max_element(area.begin(), area.end()) - area.begin());
}

}  // namespace

std::vector<std::uint32_t> injective_part(const Surface& surface, const Corners& corners, const std::vector<std::uint32_t>& faces,
                                          Vec3d axis, double tolerance)
{
    // A table is faster than searching where it is not much longer than the list.
    constexpr std::size_t sparsest = 32;
    const std::uint32_t first = faces.front();
    std::vector<std::uint32_t> table(faces.back() - first < sparsest * faces.size() ? faces.back() - first + 1 : 0, none);
    for (std::uint32_t i = 0; i < faces.size() && !table.empty(); ++i)
        table[faces[i] - first] = i;
    const auto place = [&](std::uint32_t face) {
        return table.empty() ? place_of(faces, face) : face - first < table.size() ? table[face - first] : none;
    };
    std::vector<std::array<std::uint32_t, 3>> around(faces.size(), {none, none, none});
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto g = surface.neighbors[faces[i]][k]; g != none)
                around[i][k] = place(g);

    const auto overlaps = find_overlaps(corners, faces, tolerance);
    std::vector<bool> clean(faces.size(), true);
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> conflicts;
    for (const auto& [a, b] : overlaps)
    {
        const auto i = place(a);
        const auto j = place(b);
        conflicts[i].push_back(j);
        conflicts[j].push_back(i);
        clean[i] = clean[j] = false;
    }

    struct Candidate
    {
        bool conflicted;
        double turn;
        std::uint32_t place;
        bool operator<(const Candidate& other) const
        {
            return std::tie(other.conflicted, other.turn, other.place) < std::tie(conflicted, turn, place);
        }
    };
    enum class State : std::uint8_t
    {
        open,
        kept,
        blocked
    };
    std::vector<State> state(faces.size(), State::open);
    std::vector<bool> waiting(faces.size(), false);
    std::priority_queue<Candidate> queue;
    queue.push({false, 0, best_seed(surface, faces, around, clean)});
    while (!queue.empty())
    {
        const auto i = queue.top().place;
        queue.pop();
        if (state[i] != State::open)
            continue;
        state[i] = State::kept;
        if (!clean[i])
            for (const auto j : conflicts[i])
                state[j] = State::blocked;
        for (const auto j : around[i])
            if (j != none && state[j] == State::open && !waiting[j])
            {
                waiting[j] = true;
                queue.push({!clean[j], -dot(surface.normals[faces[j]], axis), j});
            }
    }
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < faces.size(); ++i)
        if (state[i] == State::kept)
            kept.push_back(faces[i]);
    return kept;
}

namespace
{

using FaceList = std::vector<std::uint32_t>;

/// A chart that waits to be laid flat.
struct Pending
{
    FaceList faces;
    Vec3d axis{};
};

class Flattener
{
  public:
    Flattener(const Surface& surface, const FlattenOptions& options, Progress& progress)
        : surface_(surface), options_(options), progress_(progress),
          merge_cosine_(numerics::cosine_deg(options.charts.merge_limit_deg))
    {
        flat_.corners.resize(3 * surface.areas.size());
        flat_.projected.assign(surface.areas.size(), 1);
        flat_.chart_of_face.assign(surface.areas.size(), none);
    }

    /// Lays charts flat, cuts off what does not fit, and goes on with that until every face has its place.
    void lay(std::vector<Pending> pending)
    {
        while (!pending.empty())
        {
            std::vector<FaceList> kept(pending.size());
            parallel_items(pending.size(), 1, progress_, [&](std::size_t i) { kept[i] = keep(pending[i]); });
            FaceList rest;
            for (std::size_t i = 0; i < pending.size(); ++i)
            {
                const auto chart = static_cast<std::uint32_t>(flat_.axes.size());
                flat_.axes.push_back(pending[i].axis);
                for (const auto f : kept[i])
                    flat_.chart_of_face[f] = chart;
                std::ranges::set_difference(pending[i].faces, kept[i], std::back_inserter(rest));
            }
            pending = regrow(rest);
        }
    }

    /// Joins crumbs with neighbors that suit them, and lays the joined charts again.
    void merge()
    {
        Partition partition{flat_.chart_of_face, flat_.axes};
        merge_charts(surface_, surface_.normals, options_.charts, partition, progress_);
        flat_.axes.clear();
        std::fill(flat_.chart_of_face.begin(), flat_.chart_of_face.end(), none);
        lay(pending_of(partition));
    }

    /// Crumbs that fit beside a chart unchanged go first; joined ones may then leave room for more.
    void place_crumbs()
    {
        attach_crumbs(surface_, flat_, options_.texel_m, progress_);
        join_crumbs(surface_, flat_, options_.texel_m, progress_);
        attach_crumbs(surface_, flat_, options_.texel_m, progress_);
        renumber_charts(flat_.chart_of_face, flat_.axes);
    }

    static std::vector<Pending> pending_of(const Partition& partition)
    {
        std::vector<Pending> pending;
        for (auto& faces : partition.faces())
            if (!faces.empty())
                pending.push_back({std::move(faces), {}});
        return pending;
    }

    FlatCharts take() { return std::move(flat_); }

  private:
    Vec3d mean_normal(const FaceList& faces) const
    {
        Vec3d sum{};
        for (const auto f : faces)
            sum += surface_.normals[f] * surface_.areas[f];
        return normalized(sum);
    }

    bool fits(std::uint32_t face, Vec3d axis) const
    {
        return surface_.areas[face] == 0 || dot(surface_.normals[face], axis) >= merge_cosine_;
    }

    /// The part of a chart that is flat and injective; sets its axis and corners.
    FaceList keep(Pending& chart)
    {
        chart.axis = mean_normal(chart.faces);
        FaceList fitting;
        std::ranges::copy_if(chart.faces, std::back_inserter(fitting), [&](auto f) { return fits(f, chart.axis); });
        if (fitting.empty() || dot(chart.axis, chart.axis) == 0)
        {
            const auto largest = *std::ranges::max_element(chart.faces, {}, [&](auto f) { return surface_.areas[f]; });
            fitting = {largest};
            chart.axis = surface_.normals[largest];
        }
        if (dot(chart.axis, chart.axis) == 0)
            chart.axis = {0, 0, 1};
        project(fitting, chart.axis);
        return injective_part(surface_, flat_.corners, fitting, chart.axis, options_.tolerance_m());
    }

    void project(const FaceList& faces, Vec3d axis)
    {
        const Vec3d helper = std::abs(axis.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
        const Vec3d u = normalized(cross(helper, axis));
        const Vec3d v = cross(axis, u);
        for (const auto f : faces)
        {
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto p = vec_cast<double>(surface_.mesh.positions[surface_.mesh.triangles[f][k]]);
                flat_.corners[3 * std::size_t{f} + k] = {dot(u, p), dot(v, p)};
            }
        }
    }

    /// New charts from faces that found no place.
    std::vector<Pending> regrow(const FaceList& rest)
    {
        if (rest.empty())
            return {};
        Partition partition;
        partition.chart_of_face.assign(surface_.areas.size(), 0);
        partition.axes = {Vec3d{0, 0, 1}};
        for (const auto f : rest)
            partition.chart_of_face[f] = none;
        grow_charts(surface_, surface_.normals, options_.charts.angle_limit_deg, partition, progress_);
        std::vector<Pending> pending(partition.axes.size() - 1);
        for (const auto f : rest)
            pending[partition.chart_of_face[f] - 1].faces.push_back(f);
        for (auto& chart : pending)
            std::sort(chart.faces.begin(), chart.faces.end());
        return pending;
    }

    const Surface& surface_;
    const FlattenOptions& options_;
    Progress& progress_;
    double merge_cosine_;
    FlatCharts flat_;
};

}  // namespace

FlatCharts project_charts(const Surface& surface, const Partition& partition, const FlattenOptions& options, Progress& progress)
{
    Flattener flattener(surface, options, progress);
    flattener.lay(Flattener::pending_of(partition));
    progress.progress(1, 3, "rounds");
    flattener.merge();
    progress.progress(2, 3, "rounds");
    if (options.charts.merge_limit_deg > options.charts.angle_limit_deg)
        flattener.place_crumbs();
    progress.progress(3, 3, "rounds");
    return flattener.take();
}

}  // namespace fresco::geometry
