#include <fresco/geometry/flatten.h>
#include <fresco/parallel.h>

#include <cmath>
#include <numbers>

namespace fresco::geometry
{

PlaneFrame::PlaneFrame(Vec3d axis)
{
    const Vec3d helper = std::abs(axis.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    u = normalized(cross(helper, axis));
    v = cross(axis, u);
}

namespace
{

using FaceList = std::vector<std::uint32_t>;

/// A chart that waits to be laid flat.
struct Pending
{
    FaceList faces;
    bool has_corners = false;  ///< Its corners are final; only overlaps are looked for.
    Vec3d axis{};
};

class Flattener
{
  public:
    Flattener(const Surface& surface, const FlattenOptions& options, Progress& progress)
        : surface_(surface), options_(options), progress_(progress),
          merge_cosine_(std::cos(options.charts.merge_limit_deg * std::numbers::pi / 180))
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
            parallel_for(pending.size(), 1, progress_.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress_.check_cancelled();
                             for (auto i = begin; i < end; ++i)
                                 kept[i] = keep(pending[i]);
                         });
            FaceList rest;
            for (std::size_t i = 0; i < pending.size(); ++i)
            {
                const auto chart = static_cast<std::uint32_t>(flat_.axes.size());
                flat_.axes.push_back(pending[i].axis);
                for (const auto f : kept[i])
                    flat_.chart_of_face[f] = chart;
                std::set_difference(pending[i].faces.begin(), pending[i].faces.end(), kept[i].begin(), kept[i].end(),
                                    std::back_inserter(rest));
            }
            pending = regrow(rest);
        }
        flat_.count = flat_.axes.size();
    }

    /// Joins crumbs with neighbours that suit them, and lays the joined charts again.
    void merge()
    {
        Partition partition{flat_.chart_of_face, flat_.axes};
        merge_charts(surface_, surface_.normals, options_.charts, partition, progress_);
        restart();
        lay(pending_of(partition));
    }

    void unfold()
    {
        const auto changed = unfold_crumbs(surface_, flat_, options_.texel_m, progress_);
        Partition partition{flat_.chart_of_face, flat_.axes};
        auto lists = partition.faces();
        std::vector<Pending> again;
        restart();
        for (std::size_t c = 0; c < lists.size(); ++c)
        {
            if (lists[c].empty())
                continue;
            if (changed[c])
                again.push_back({std::move(lists[c]), true, partition.axes[c]});
            else
            {
                for (const auto f : lists[c])
                    flat_.chart_of_face[f] = static_cast<std::uint32_t>(flat_.axes.size());
                flat_.axes.push_back(partition.axes[c]);
            }
        }
        lay(std::move(again));
    }

    void attach() { attach_crumbs(surface_, flat_, options_.texel_m, progress_); }

    static std::vector<Pending> pending_of(const Partition& partition)
    {
        std::vector<Pending> pending;
        for (auto& faces : partition.faces())
            if (!faces.empty())
                pending.push_back({std::move(faces), false, {}});
        return pending;
    }

    FlatCharts take() { return std::move(flat_); }

  private:
    void restart()
    {
        flat_.axes.clear();
        std::fill(flat_.chart_of_face.begin(), flat_.chart_of_face.end(), none);
    }

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
        if (!chart.has_corners)
        {
            chart.axis = mean_normal(chart.faces);
            FaceList fitting;
            std::copy_if(chart.faces.begin(), chart.faces.end(), std::back_inserter(fitting),
                         [&](auto f) { return fits(f, chart.axis); });
            if (fitting.empty() || dot(chart.axis, chart.axis) == 0)
            {
                const auto largest = *std::max_element(chart.faces.begin(), chart.faces.end(),
                                                       [&](auto a, auto b) { return surface_.areas[a] < surface_.areas[b]; });
                fitting = {largest};
                chart.axis = surface_.normals[largest];
            }
            if (dot(chart.axis, chart.axis) == 0)
                chart.axis = {0, 0, 1};
            project(fitting, chart.axis);
            return injective_part(surface_, flat_.corners, fitting, chart.axis, options_.tolerance_m());
        }
        return injective_part(surface_, flat_.corners, chart.faces, chart.axis, options_.tolerance_m());
    }

    void project(const FaceList& faces, Vec3d axis)
    {
        const PlaneFrame frame(axis);
        for (const auto f : faces)
        {
            flat_.projected[f] = 1;
            for (std::size_t k = 0; k < 3; ++k)
                flat_.corners[3 * std::size_t{f} + k] =
                    frame.project(vec_cast<double>(surface_.mesh.positions[surface_.mesh.triangles[f][k]]));
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
    progress.progress(1, 3, "passes");
    flattener.merge();
    progress.progress(2, 3, "passes");
    // What can be laid beside a neighbour as it is comes before what must be bent, and what was cut off then is tried once more.
    const bool crumbs_may_join = options.charts.merge_limit_deg > options.charts.angle_limit_deg;
    if (crumbs_may_join)
        flattener.attach();
    flattener.unfold();
    if (crumbs_may_join)
        flattener.attach();
    progress.progress(3, 3, "passes");
    return flattener.take();
}

}  // namespace fresco::geometry
