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
                             progress_.check_canceled();
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

    /// Joins crumbs with neighbors that suit them, and lays the joined charts again.
    void merge()
    {
        Partition partition{flat_.chart_of_face, flat_.axes};
        merge_charts(surface_, surface_.normals, options_.charts, partition, progress_);
        restart();
        lay(pending_of(partition));
    }

    /// Has the charts laid better, and lays what found no place there.
    void improve(const LayFlat& lay_flat)
    {
        lay_flat(flat_);
        FaceList rest;
        for (std::uint32_t f = 0; f < flat_.chart_of_face.size(); ++f)
            if (flat_.chart_of_face[f] == none)
                rest.push_back(f);
        lay(regrow(rest));
    }

    /// Those that fit beside a chart as they are go first; what was joined then may leave room for more.
    void place_crumbs()
    {
        attach_crumbs(surface_, flat_, options_.texel_m, progress_);
        join_crumbs(surface_, flat_, options_.texel_m, progress_);
        attach_crumbs(surface_, flat_, options_.texel_m, progress_);
        renumber();
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
    /// Leaves no number without faces.
    void renumber()
    {
        std::vector<std::uint32_t> number(flat_.axes.size(), none);
        std::vector<Vec3d> axes;
        for (auto& c : flat_.chart_of_face)
        {
            if (number[c] == none)
            {
                number[c] = static_cast<std::uint32_t>(axes.size());
                axes.push_back(flat_.axes[c]);
            }
            c = number[c];
        }
        flat_.axes = std::move(axes);
        flat_.count = flat_.axes.size();
    }

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

FlatCharts project_charts(const Surface& surface, const Partition& partition, const FlattenOptions& options, Progress& progress,
                          const LayFlat& lay_flat)
{
    Flattener flattener(surface, options, progress);
    flattener.lay(Flattener::pending_of(partition));
    progress.progress(1, 3, "passes");
    flattener.merge();
    progress.progress(2, 3, "passes");
    if (lay_flat)
        flattener.improve(lay_flat);
    if (options.charts.merge_limit_deg > options.charts.angle_limit_deg)
        flattener.place_crumbs();
    progress.progress(3, 3, "passes");
    return flattener.take();
}

}  // namespace fresco::geometry
