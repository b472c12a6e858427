#include "relaxation.h"

#include <fresco/geometry/map_charts.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <atomic>
#include <cmath>
#include <numeric>

namespace fresco::geometry
{
namespace
{

using FaceList = std::vector<std::uint32_t>;

/// Pieces of fewer faces are not cut in two.
constexpr std::size_t smallest_halved = 128;
/// More faces are halved first: a map is made in one go, in memory that grows faster than the faces.
constexpr std::size_t most_mapped = 65536;
constexpr int most_halvings = 6;
constexpr double smallest_kept_share = 0.9;
constexpr double largest_square_stretch = 1.2 * 1.2;
/// How far from a folded face the map may be relaxed, in rings.
constexpr int mended_rings = 3;
constexpr int mending_sweeps = 60;

/// A connected part of a chart.
struct Piece
{
    FaceList faces;
    bool mapped = false;
};

struct ChartResult
{
    std::vector<Piece> pieces;  ///< Faces in none of them were cut off.
    MapCounts counts;           ///< The areas are not shares yet.
};

double area_of(const Disk& disk, std::size_t f)
{
    const auto& t = disk.triangles[f];
    return 0.5 * length(cross(disk.points[t[1]] - disk.points[t[0]], disk.points[t[2]] - disk.points[t[0]]));
}

double area_of(const std::vector<Vec2d>& places, const Triangle& t)
{
    return 0.5 * cross(places[t[1]] - places[t[0]], places[t[2]] - places[t[0]]);
}

/// Relaxes a map around the faces that it folds or squeezes.
class Mender
{
  public:
    Mender(const Disk& disk, std::vector<Vec2d>& places)
        : disk_(disk), places_(places), around_(places.size(),
                                                [&](const auto& add)
                                                {
                                                    for (std::uint32_t f = 0; f < disk.triangles.size(); ++f)
                                                        for (const auto v : disk.triangles[f])
                                                            add(v, f);
                                                }),
          patch_of_(disk.triangles.size(), none)
    {
    }

    void mend()
    {
        FaceList bad;
        for (std::uint32_t f = 0; f < disk_.triangles.size(); ++f)
            if (const double own = area_of(disk_, f); own > 0 && area_of(places_, disk_.triangles[f]) < smallest_area_share * own)
                bad.push_back(f);
        // A map that is mostly folded is useless.
        if (10 * bad.size() > disk_.triangles.size())
            return;
        for (const auto f : bad)
            patch_of_[f] = 0;
        for (int ring = 0; ring < mended_rings; ++ring)
            for (std::size_t i = 0, count = bad.size(); i < count; ++i)
                add_around(bad[i], none, 0, bad);
        std::uint32_t patch = 0;
        for (const auto f : bad)
            if (patch_of_[f] == 0)
            {
                ++patch;
                relax_patch(collect(f, patch), patch);
            }
    }

  private:
    /// Adds the faces beside face `f` that are marked `from`, and marks them `to`.
    void add_around(std::uint32_t f, std::uint32_t from, std::uint32_t to, FaceList& faces)
    {
        for (const auto v : disk_.triangles[f])
            for (const auto g : around_[v])
                if (patch_of_[g] == from)
                {
                    patch_of_[g] = to;
                    faces.push_back(g);
                }
    }

    /// The faces to mend that hang together with this one by vertices.
    FaceList collect(std::uint32_t seed, std::uint32_t patch)
    {
        FaceList faces{seed};
        patch_of_[seed] = patch;
        for (std::size_t i = 0; i < faces.size(); ++i)
            add_around(faces[i], 0, patch, faces);
        return faces;
    }

    void relax_patch(const FaceList& faces, std::uint32_t patch)
    {
        FaceList vertices;
        for (const auto f : faces)
            vertices.insert(vertices.end(), disk_.triangles[f].begin(), disk_.triangles[f].end());
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
        FlatPatch shape;
        for (const auto v : vertices)
        {
            const auto around = around_[v];
            shape.places.push_back(places_[v]);
            shape.movable.push_back(
                std::all_of(around.begin(), around.end(), [&](std::uint32_t f) { return patch_of_[f] == patch; }));
        }
        for (const auto f : faces)
        {
            Triangle t;
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto v = disk_.triangles[f][k];
                t[k] = place_of(vertices, v);
                shape.points.push_back(disk_.points[v]);
            }
            shape.triangles.push_back(t);
        }
        relax(shape, mending_sweeps);
        for (std::size_t i = 0; i < vertices.size(); ++i)
            places_[vertices[i]] = shape.places[i];
    }

    const Disk& disk_;
    std::vector<Vec2d>& places_;
    numerics::Buckets around_;             ///< Faces by vertex.
    std::vector<std::uint32_t> patch_of_;  ///< none: fine; 0: to be mended; else the patch, from 1.
};

/// Scales the places to the surface's area; false if they have none.
bool scale(const Disk& disk, std::vector<Vec2d>& places)
{
    double on_surface = 0;
    double laid = 0;
    for (std::size_t f = 0; f < disk.triangles.size(); ++f)
    {
        on_surface += area_of(disk, f);
        laid += area_of(places, disk.triangles[f]);
    }
    if (!(laid > 0) || !std::isfinite(laid))
        return false;
    for (auto& p : places)
        p = p * std::sqrt(on_surface / laid);
    return true;
}

class ChartMapper
{
  public:
    ChartMapper(const Surface& surface, FlatCharts& flat, const DiskMap& map, double tolerance_m)
        : surface_(surface), flat_(flat), map_(map), tolerance_m_(tolerance_m)
    {
    }

    /// Works only on a chart's faces: charts may be mapped in parallel.
    ChartResult run(const FaceList& chart, Vec3d axis, const Progress& progress) const
    {
        ChartResult result;
        result.counts.single_triangles = chart.size() == 1 ? 1 : 0;
        std::vector<std::pair<FaceList, int>> open;
        if (chart.size() > 1)
            open.emplace_back(chart, 0);
        while (!open.empty())
        {
            progress.check_canceled();
            auto [faces, halvings] = std::move(open.back());
            open.pop_back();
            const bool too_many = faces.size() > most_mapped;
            if (auto kept = too_many ? FaceList{} : mapped(faces, axis, result.counts); !kept.empty())
                result.pieces.push_back({std::move(kept), true});
            else if (too_many || (faces.size() >= smallest_halved && halvings < most_halvings))
            {
                ++result.counts.halved_charts;
                auto [one, other] = halves(faces);
                const int next = halvings + (too_many ? 0 : 1);
                open.emplace_back(std::move(other), next);
                open.emplace_back(std::move(one), next);
            }
            else
                result.pieces.push_back({std::move(faces), false});
        }
        // Cutting was for nothing where no piece could be mapped.
        if (std::none_of(result.pieces.begin(), result.pieces.end(), [](const Piece& p) { return p.mapped; }))
        {
            result.pieces = {{chart, false}};
            result.counts.halved_charts = 0;
        }
        return result;
    }

  private:
    /// Lays faces by the map and returns those that lie well; none, and nothing has changed, if it is no use.
    FaceList mapped(const FaceList& faces, Vec3d axis, MapCounts& counts) const
    {
        const auto disk = cut_to_disk(surface_, faces);
        std::vector<Vec2d> projected(disk.points.size());
        for (std::size_t i = 0; i < faces.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k)
                projected[disk.triangles[i][k]] = flat_.corners[3 * std::size_t{faces[i]} + k];
        auto places = map_(disk, projected);
        if (!places || !scale(disk, *places))
            return {};
        Mender(disk, *places).mend();

        FaceList good;
        double area = 0;
        double square_stretch = 0;
        double good_area = 0;
        for (std::size_t i = 0; i < faces.size(); ++i)
        {
            const double on_surface = surface_.areas[faces[i]];
            area += on_surface;
            if (on_surface > 0 && !(area_of(*places, disk.triangles[i]) >= smallest_area_share * on_surface))
                continue;
            good.push_back(faces[i]);
            good_area += on_surface;
            if (on_surface > 0)
                square_stretch += on_surface * stretch_of(disk, *places, i);
        }
        if (good_area < smallest_kept_share * area || square_stretch > largest_square_stretch * good_area)
            return {};

        Corners before;
        for (std::size_t i = 0; i < faces.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k)
            {
                auto& corner = flat_.corners[3 * std::size_t{faces[i]} + k];
                before.push_back(corner);
                corner = (*places)[disk.triangles[i][k]];
            }
        auto kept = injective_part(surface_, flat_.corners, good, axis, tolerance_m_);
        double kept_area = 0;
        for (const auto f : kept)
            kept_area += surface_.areas[f];
        if (kept_area < smallest_kept_share * area)
        {
            for (std::size_t i = 0; i < before.size(); ++i)
                flat_.corners[3 * std::size_t{faces[i / 3]} + i % 3] = before[i];
            return {};
        }
        for (const auto f : kept)
            flat_.projected[f] = 0;
        ++counts.mapped_charts;
        counts.cut_edges += disk.cut_edges;
        counts.cut_off_faces += faces.size() - kept.size();
        counts.mapped_area_share += kept_area;
        return kept;
    }

    static double stretch_of(const Disk& disk, const std::vector<Vec2d>& places, std::size_t f)
    {
        FlatPatch one;
        one.triangles = {{0, 1, 2}};
        one.movable.assign(3, false);
        for (const auto v : disk.triangles[f])
        {
            one.points.push_back(disk.points[v]);
            one.places.push_back(places[v]);
        }
        return relax(one, 0).square_stretch;
    }

    /// The faces nearer to one of two that are far apart, and those nearer to the other, counted in faces: both connected.
    std::pair<FaceList, FaceList> halves(const FaceList& faces) const
    {
        std::vector<std::uint32_t> side;
        const auto flood = [&](std::vector<std::uint32_t> front)
        {
            side.assign(faces.size(), none);
            for (std::uint32_t s = 0; s < front.size(); ++s)
                side[front[s]] = s;
            for (std::size_t i = 0; i < front.size(); ++i)
                for (const auto g : surface_.neighbors[faces[front[i]]])
                    if (g != none)
                        if (const auto j = place_of(faces, g); j != none && side[j] == none)
                        {
                            side[j] = side[front[i]];
                            front.push_back(j);
                        }
            return front.back();
        };
        const auto one = flood({0});
        const auto other = flood({one});
        flood({one, other});
        std::pair<FaceList, FaceList> result;
        for (std::size_t i = 0; i < faces.size(); ++i)
            (side[i] == 0 ? result.first : result.second).push_back(faces[i]);
        return result;
    }

    const Surface& surface_;
    FlatCharts& flat_;
    const DiskMap& map_;
    double tolerance_m_;
};

}  // namespace

MapCounts map_charts(const Surface& surface, FlatCharts& flat, const DiskMap& map, double tolerance_m, Progress& progress)
{
    const auto lists = flat.faces();
    const ChartMapper mapper(surface, flat, map, tolerance_m);
    std::vector<ChartResult> results(lists.size());
    std::atomic<std::size_t> done{0};
    parallel_items(lists.size(), 1, progress,
                   [&](std::size_t c)
                   {
                       if (!lists[c].empty())
                           results[c] = mapper.run(lists[c], flat.axes[c], progress);
                       done += lists[c].size();
                       progress.progress(static_cast<double>(done), static_cast<double>(surface.areas.size()), "faces");
                   });

    MapCounts total;
    const double area = std::accumulate(surface.areas.begin(), surface.areas.end(), 0.0);
    std::fill(flat.chart_of_face.begin(), flat.chart_of_face.end(), none);
    const auto axes = std::move(flat.axes);
    flat.axes.clear();
    for (std::size_t c = 0; c < results.size(); ++c)
    {
        const auto& counts = results[c].counts;
        for (const auto count : {&MapCounts::mapped_charts, &MapCounts::single_triangles, &MapCounts::halved_charts,
                                 &MapCounts::cut_edges, &MapCounts::cut_off_faces})
            total.*count += counts.*count;
        total.mapped_area_share += area > 0 ? counts.mapped_area_share / area : 0;
        for (const auto& piece : results[c].pieces)
        {
            total.projected_charts += !piece.mapped && piece.faces.size() > 1 ? 1 : 0;
            for (const auto f : piece.faces)
                flat.chart_of_face[f] = static_cast<std::uint32_t>(flat.axes.size());
            flat.axes.push_back(axes[c]);
        }
    }
    return total;
}

void report_mapping(RunContext& run, const MapCounts& counts)
{
    run.report("mapped_charts", counts.mapped_charts);
    run.report("projected_charts", counts.projected_charts);
    run.report("single_triangles", counts.single_triangles);
    run.report("halved_charts", counts.halved_charts);
    run.report("cut_edges", counts.cut_edges);
    run.report("cut_off_faces", counts.cut_off_faces);
    run.report("mapped_area_share", counts.mapped_area_share);
}

}  // namespace fresco::geometry
