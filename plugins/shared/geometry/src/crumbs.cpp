#include "relaxation.h"

#include <fresco/geometry/flatten.h>
#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace fresco::geometry
{

namespace
{

using FaceList = std::vector<std::uint32_t>;

/// About a face's size, and so large that all faces together touch a few cells each, however large some of them are.
double cell_size(const FlatCharts& flat)
{
    double edges = 0;
    double boxes = 0;
    for (std::size_t c = 0; c < flat.corners.size(); c += 3)
    {
        const Vec2d size = FlatBox(std::span(flat.corners).subspan(c, 3)).size();
        edges += std::max(size.x, size.y);
        boxes += size.x * size.y;
    }
    const auto faces = std::max(static_cast<double>(flat.chart_of_face.size()), 1.0);
    return std::max({1.5 * edges / faces, std::sqrt(boxes / faces), 1e-9});
}

/// Flat charts whose faces change places: who has which faces, and where each lies. Refers to both, which must outlive it;
/// changes `flat` alone. Not thread-safe.
class MovingCharts
{
  public:
    MovingCharts(const Surface& surface, FlatCharts& flat)
        : surface_(surface), flat_(flat), faces_(flat.faces()), cell_m_(cell_size(flat))
    {
        cells_.reserve(flat.chart_of_face.size());
        for (std::uint32_t f = 0; f < flat.chart_of_face.size(); ++f)
            enter(f);
    }

    const Surface& surface() const { return surface_; }
    const FlatCharts& flat() const { return flat_; }
    const FaceList& faces(std::uint32_t chart) const { return faces_[chart]; }

    /// Calls place(crumb) for each chart of a few faces and at most so large an area, those of the fewest faces first. Returns
    /// how many found a place.
    template <class Place>
    std::size_t place_crumbs(double largest_m2, const Progress& progress, const Place& place) const
    {
        std::vector<std::uint32_t> crumbs;
        for (std::uint32_t c = 0; c < faces_.size(); ++c)
            if (is_crumb(c, largest_m2))
                crumbs.push_back(c);
        std::ranges::stable_sort(crumbs, {}, [&](std::uint32_t c) { return faces_[c].size(); });
        std::size_t placed = 0;
        for (const auto crumb : crumbs)
        {
            progress.check_canceled();
            // It may have grown by others, or be gone.
            placed += is_crumb(crumb, largest_m2) && place(crumb) ? 1 : 0;
        }
        return placed;
    }

    /// The charts of no fewer faces that share edges with this one, longest common border first.
    std::vector<std::uint32_t> neighbors(std::uint32_t chart) const
    {
        auto charts = charts_beside(surface_, flat_.chart_of_face, faces_[chart]);
        std::erase_if(charts, [&](std::uint32_t other) { return faces_[other].size() < faces_[chart].size(); });
        return charts;
    }

    /// Corner at which a face has a vertex: an index into the flat corners.
    std::size_t corner(std::uint32_t face, std::uint32_t vertex) const
    {
        const auto& t = surface_.mesh.triangles[face];
        return 3 * std::size_t{face} + (t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2);
    }
    Vec2d place(std::uint32_t face, std::uint32_t vertex) const { return flat_.corners[corner(face, vertex)]; }

    /// Whether a triangle lies deeper than `tolerance` on a face of the chart for which `counts(face)` holds.
    template <class Counts>
    bool covered(std::uint32_t chart, std::span<const Vec2d, 3> corners, double tolerance, Counts counts) const
    {
        bool found = false;
        each_cell(chart, corners,
                  [&](Key key)
                  {
                      const auto cell = cells_.find(key);
                      if (cell == cells_.end() || found)
                          return;
                      for (const std::uint32_t face : cell->second)
                          found = found || (flat_.chart_of_face[face] == chart && counts(face) &&
                                            overlap_depth(corners, triangle(face)) > tolerance);
                  });
        return found;
    }

    /// Lays a face again, in this chart.
    void lay(std::uint32_t face, std::uint32_t chart, std::span<const Vec2d, 3> corners)
    {
        std::copy(corners.begin(), corners.end(), flat_.corners.begin() + 3 * std::ptrdiff_t{face});
        flat_.chart_of_face[face] = chart;
        flat_.projected[face] = 0;
        enter(face);
    }

    /// Notes that all faces of a crumb were laid in a chart.
    void dissolve(std::uint32_t crumb, std::uint32_t chart)
    {
        faces_[chart].insert(faces_[chart].end(), faces_[crumb].begin(), faces_[crumb].end());
        flat_.unfolded_faces += faces_[crumb].size();
        faces_[crumb].clear();
    }

  private:
    using Key = std::uint64_t;

    bool is_crumb(std::uint32_t chart, double largest_m2) const
    {
        if (faces_[chart].empty() || faces_[chart].size() > crumb_faces)
            return false;
        double area = 0;
        for (const auto f : faces_[chart])
            area += surface_.areas[f];
        return area <= largest_m2;
    }

    template <class Act>
    void each_cell(std::uint32_t chart, std::span<const Vec2d, 3> t, Act act) const
    {
        const auto bin = [&](double value) { return static_cast<std::int64_t>(std::floor(value / cell_m_)); };
        const FlatBox box(t);
        for (auto y = bin(box.low.y); y <= bin(box.high.y); ++y)
            for (auto x = bin(box.low.x); x <= bin(box.high.x); ++x)
                act((static_cast<Key>(chart) << 36) ^ (static_cast<Key>(y & 0x3ffff) << 18) ^ static_cast<Key>(x & 0x3ffff));
    }

    std::span<const Vec2d, 3> triangle(std::uint32_t face) const
    {
        return std::span<const Vec2d, 3>(flat_.corners.data() + 3 * std::size_t{face}, 3);
    }
    void enter(std::uint32_t face)
    {
        each_cell(flat_.chart_of_face[face], triangle(face), [&](Key key) { cells_[key].push_back(face); });
    }

    const Surface& surface_;
    FlatCharts& flat_;
    std::vector<FaceList> faces_;  ///< By chart.
    double cell_m_;
    /// Faces by the cells of their chart that their boxes touch. A face that moves is entered again and stays where it was: it is
    /// always looked at where it is now.
    std::unordered_map<Key, FaceList> cells_;
};

/// A crumb and the faces of a chart around it, to be laid out together.
struct CrumbPatch
{
    FaceList faces;
    FlatPatch shape;             ///< Triangles in the order of the faces.
    std::vector<bool> on_chart;  ///< Per vertex: it has a place in the chart already.
};

/// Corners of one vertex that differ by less (meters) are in one place.
constexpr double same_place_m = 1e-9;
constexpr int contractions = 20;

void unroll(CrumbPatch& patch)
{
    auto& shape = patch.shape;
    auto known = patch.on_chart;
    for (bool more = true; more;)
    {
        more = false;
        for (std::size_t f = 0; f < shape.triangles.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto from = shape.triangles[f][k];
                const auto to = shape.triangles[f][(k + 1) % 3];
                const auto apex = shape.triangles[f][(k + 2) % 3];
                if (!known[from] || !known[to] || known[apex])
                    continue;
                const auto base = shape.points[3 * f + k];
                const auto edge = shape.points[3 * f + (k + 1) % 3] - base;
                const auto side = shape.points[3 * f + (k + 2) % 3] - base;
                const auto flat_edge = shape.places[to] - shape.places[from];
                if (!(dot(edge, edge) > 0) || !(dot(flat_edge, flat_edge) > 0))
                    continue;
                const double along = dot(side, edge) / dot(edge, edge);
                const double height = length(cross(edge, side)) / length(edge);
                const Vec2d left = normalized(Vec2d{-flat_edge.y, flat_edge.x});
                shape.places[apex] = shape.places[from] + flat_edge * along + left * height;
                known[apex] = true;
                more = true;
            }
    }
}

/// Makes patches; keeps room for them between calls. Refers to the charts, which must outlive it.
class PatchMaker
{
  public:
    explicit PatchMaker(const MovingCharts& charts) : charts_(charts), place_(charts.surface().areas.size(), none) {}

    /// The crumb and what of the chart is within `steps` faces of it. The crumb's edges to the chart and inside are closed; the
    /// chart's own cuts stay open. Vertices that further faces of the chart hang on are not movable. The crumb's are unrolled: as
    /// if its faces were turned about their edges into the plane. Nothing if the crumb ties places of the chart together that
    /// must stay apart.
    std::optional<CrumbPatch> make(std::uint32_t crumb, std::uint32_t chart, int steps)
    {
        FaceList faces = collect(crumb, chart, steps);
        auto patch = assemble(faces, chart);
        for (const auto f : faces)
            place_[f] = none;
        if (!patch)
            return std::nullopt;
        patch->faces = std::move(faces);
        unroll(*patch);
        return patch;
    }

  private:
    FaceList collect(std::uint32_t crumb, std::uint32_t chart, int steps)
    {
        const auto& surface = charts_.surface();
        const auto& owner = charts_.flat().chart_of_face;
        FaceList patch = charts_.faces(crumb);
        for (std::uint32_t i = 0; i < patch.size(); ++i)
            place_[patch[i]] = i;
        std::size_t begin = 0;
        for (int step = 0; step < steps; ++step)
        {
            const auto end = patch.size();
            for (; begin < end; ++begin)
                for (std::size_t k = 0; k < 3; ++k)
                {
                    const auto f = patch[begin];
                    const auto g = surface.neighbors[f][k];
                    if (g == none || owner[g] != chart || place_[g] != none)
                        continue;
                    const auto& t = surface.mesh.triangles[f];
                    if (owner[f] == chart && !(together(f, g, t[k]) && together(f, g, t[(k + 1) % 3])))
                        continue;
                    place_[g] = static_cast<std::uint32_t>(patch.size());
                    patch.push_back(g);
                }
        }
        return patch;
    }

    std::optional<CrumbPatch> assemble(const FaceList& patch, std::uint32_t chart) const
    {
        const auto& surface = charts_.surface();
        const auto& owner = charts_.flat().chart_of_face;
        const auto in_patch = [&](std::uint32_t face, std::uint32_t vertex) {
            return static_cast<std::uint32_t>(3 * std::size_t{place_[face]} + charts_.corner(face, vertex) -
                                              3 * std::size_t{face});
        };

        numerics::DisjointSets corners(3 * patch.size());
        std::vector<bool> held(3 * patch.size(), false);
        for (const auto f : patch)
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto g = surface.neighbors[f][k];
                if (g == none)
                    continue;
                const bool of_chart = owner[f] == chart && owner[g] == chart;
                const std::array ends{surface.mesh.triangles[f][k], surface.mesh.triangles[f][(k + 1) % 3]};
                if (place_[g] != none)
                {
                    if (!of_chart || (together(f, g, ends[0]) && together(f, g, ends[1])))
                        for (const auto v : ends)
                            corners.join(in_patch(f, v), in_patch(g, v));
                }
                else if (of_chart)
                    for (const auto v : ends)
                        held[in_patch(f, v)] = held[in_patch(f, v)] || together(f, g, v);
            }

        CrumbPatch out;
        auto& shape = out.shape;
        std::vector<std::uint32_t> vertex_of(3 * patch.size(), none);
        for (std::uint32_t i = 0; i < patch.size(); ++i)
        {
            Triangle triangle;
            for (std::uint32_t k = 0; k < 3; ++k)
            {
                auto& v = vertex_of[corners.find(3 * i + k)];
                if (v == none)
                {
                    v = static_cast<std::uint32_t>(shape.places.size());
                    shape.places.emplace_back();
                    shape.movable.push_back(true);
                    out.on_chart.push_back(false);
                }
                triangle[k] = v;
                const auto on_surface = surface.mesh.triangles[patch[i]][k];
                shape.points.push_back(vec_cast<double>(surface.mesh.positions[on_surface]));
                if (owner[patch[i]] != chart)
                    continue;
                const auto place = charts_.place(patch[i], on_surface);
                if (held[3 * i + k] && !shape.movable[v] && length(place - shape.places[v]) > same_place_m)
                    return std::nullopt;
                if (held[3 * i + k] || !out.on_chart[v])
                    shape.places[v] = place;
                shape.movable[v] = shape.movable[v] && !held[3 * i + k];
                out.on_chart[v] = true;
            }
            shape.triangles.push_back(triangle);
        }
        return out;
    }

    bool together(std::uint32_t f, std::uint32_t g, std::uint32_t vertex) const
    {
        return length(charts_.place(f, vertex) - charts_.place(g, vertex)) <= same_place_m;
    }

    const MovingCharts& charts_;
    std::vector<std::uint32_t> place_;  ///< Position of every face in the patch, or `none`.
};

/// Draws the crumb's vertices into the middle of their neighbors: a beginning for crumbs that the chart surrounds.
void contract(CrumbPatch& patch)
{
    auto& places = patch.shape.places;
    for (int i = 0; i < contractions; ++i)
    {
        std::vector<Vec2d> sum(places.size());
        std::vector<double> count(places.size());
        for (const auto& t : patch.shape.triangles)
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t m = 1; m < 3; ++m)
                {
                    sum[t[k]] = sum[t[k]] + places[t[(k + m) % 3]];
                    ++count[t[k]];
                }
        for (std::size_t v = 0; v < places.size(); ++v)
            if (!patch.on_chart[v])
                places[v] = sum[v] * (1 / count[v]);
    }
}

/// Charts of more texels stay where they are.
constexpr double attached_texels = 256;
/// A crumb may be laid out larger or smaller by this factor, to fit the edge that it joins at.
constexpr double largest_scale = 1.25;
/// Edges that are tried for each neighboring chart, the longest ones.
constexpr std::size_t tried_edges = 3;
constexpr int rounds = 4;

class Attacher
{
  public:
    Attacher(const Surface& surface, FlatCharts& flat, double texel_m)
        : charts_(surface, flat), largest_m2_(attached_texels * texel_m * texel_m), tolerance_m_(1e-3 * texel_m)
    {
    }

    /// Returns how many crumbs found a place.
    std::size_t run(const Progress& progress)
    {
        std::size_t placed = 0;
        for (int i = 0; i < rounds; ++i)
        {
            const std::size_t now =
                charts_.place_crumbs(largest_m2_, progress, [&](std::uint32_t crumb) { return place(crumb); });
            placed += now;
            if (now == 0)
                break;
        }
        return placed;
    }

  private:
    /// An edge between a crumb and another chart.
    struct Seam
    {
        std::uint32_t face, corner, other;
        double length_m;
    };

    bool place(std::uint32_t crumb)
    {
        const auto& surface = charts_.surface();
        const auto& flat = charts_.flat();
        std::map<std::uint32_t, std::vector<Seam>> seams;
        for (const std::uint32_t f : charts_.faces(crumb))
            for (std::uint32_t k = 0; k < 3; ++k)
                if (const auto g = surface.neighbors[f][k]; g != none && flat.chart_of_face[g] != crumb)
                    seams[flat.chart_of_face[g]].push_back(
                        {f, k, g, length(flat.corners[3 * std::size_t{f} + (k + 1) % 3] - flat.corners[3 * std::size_t{f} + k])});
        for (const auto chart : charts_.neighbors(crumb))
        {
            auto& edges = seams[chart];
            std::ranges::stable_sort(edges, std::greater<>(), &Seam::length_m);
            for (std::size_t i = 0; i < std::min(tried_edges, edges.size()); ++i)
                if (place_at(crumb, chart, edges[i]))
                    return true;
        }
        return false;
    }

    bool place_at(std::uint32_t crumb, std::uint32_t chart, const Seam& seam)
    {
        const auto& t = charts_.surface().mesh.triangles[seam.face];
        const auto a = t[seam.corner];
        const auto b = t[(seam.corner + 1) % 3];
        const Vec2d a_here = charts_.place(seam.face, a);
        const Vec2d a_there = charts_.place(seam.other, a);
        const Vec2d from = charts_.place(seam.face, b) - a_here;
        const Vec2d to = charts_.place(seam.other, b) - a_there;
        const double scale = length(to) / seam.length_m;
        if (!(scale <= largest_scale && scale >= 1 / largest_scale))
            return false;
        // Complex numbers, so that shapes stay: z -> turn * z + shift takes the edge there.
        const Vec2d turn{dot(from, to) / dot(from, from), cross(from, to) / dot(from, from)};
        const auto turned = [&](Vec2d p) { return Vec2d{turn.x * p.x - turn.y * p.y, turn.y * p.x + turn.x * p.y}; };
        const Vec2d shift = a_there - turned(a_here);
        std::vector<std::array<Vec2d, 3>> corners;
        corners.reserve(charts_.faces(crumb).size());
        for (const std::uint32_t f : charts_.faces(crumb))
        {
            const auto* corner = &charts_.flat().corners[3 * std::size_t{f}];
            corners.push_back({turned(corner[0]) + shift, turned(corner[1]) + shift, turned(corner[2]) + shift});
            if (charts_.covered(chart, corners.back(), tolerance_m_, [](std::uint32_t) { return true; }))
                return false;
        }
        for (std::size_t i = 0; i < corners.size(); ++i)
            charts_.lay(charts_.faces(crumb)[i], chart, corners[i]);
        charts_.dissolve(crumb, chart);
        return true;
    }

    MovingCharts charts_;
    double largest_m2_;
    double tolerance_m_;
};

}  // namespace

std::size_t attach_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress)
{
    return Attacher(surface, flat, texel_m).run(progress);
}

namespace
{

/// Larger charts are not noise and stay.
constexpr double joined_texels = 512;
/// Charts that are tried for each crumb, those of the longest common borders.
constexpr std::size_t tried_charts = 2;
/// How far the chart gives way, in faces: as little as will do.
constexpr std::array<int, 2> tried_steps{2, 5};
constexpr int joining_sweeps = 40;
/// Largest L² stretch of a patch (Sander et al. 2001), squared.
constexpr double largest_patch_stretch = 10;

class Joiner
{
  public:
    Joiner(const Surface& surface, FlatCharts& flat, double texel_m)
        : charts_(surface, flat), patches_(charts_), largest_m2_(joined_texels * texel_m * texel_m), tolerance_m_(1e-3 * texel_m),
          in_patch_(surface.areas.size(), false)
    {
    }

    std::size_t run(const Progress& progress)
    {
        return charts_.place_crumbs(largest_m2_, progress, [&](std::uint32_t crumb) { return join(crumb); });
    }

  private:
    bool join(std::uint32_t crumb)
    {
        const auto neighbors = charts_.neighbors(crumb);
        for (std::size_t i = 0; i < std::min(neighbors.size(), tried_charts); ++i)
            for (const int steps : tried_steps)
                for (const bool contracted : {false, true})
                {
                    auto patch = patches_.make(crumb, neighbors[i], steps);
                    if (!patch)
                        continue;
                    if (contracted)
                        contract(*patch);
                    const PatchFigures figures = relax(patch->shape, joining_sweeps);
                    if (!(figures.least_area_share >= smallest_area_share && figures.square_stretch <= largest_patch_stretch))
                        continue;
                    const auto corners = corners_of(patch->shape);
                    if (overlaps(*patch, corners, neighbors[i]))
                        continue;
                    for (std::size_t f = 0; f < patch->faces.size(); ++f)
                        charts_.lay(patch->faces[f], neighbors[i], std::span(corners).subspan(3 * f).first<3>());
                    charts_.dissolve(crumb, neighbors[i]);
                    return true;
                }
        return false;
    }

    static Corners corners_of(const FlatPatch& shape)
    {
        Corners corners;
        corners.reserve(3 * shape.triangles.size());
        for (const auto& t : shape.triangles)
            for (const auto v : t)
                corners.push_back(shape.places[v]);
        return corners;
    }

    /// Whether the patch overlaps itself or the rest of the chart.
    bool overlaps(const CrumbPatch& patch, const Corners& corners, std::uint32_t chart)
    {
        std::vector<std::uint32_t> all(patch.faces.size());
        std::iota(all.begin(), all.end(), 0u);
        if (!find_overlaps(corners, all, tolerance_m_).empty())
            return true;
        for (const auto f : patch.faces)
            in_patch_[f] = true;
        bool found = false;
        for (std::size_t f = 0; f < patch.faces.size() && !found; ++f)
            found = charts_.covered(chart, std::span(corners).subspan(3 * f).first<3>(), tolerance_m_,
                                    [&](std::uint32_t face) { return !in_patch_[face]; });
        for (const auto f : patch.faces)
            in_patch_[f] = false;
        return found;
    }

    MovingCharts charts_;
    PatchMaker patches_;
    double largest_m2_;
    double tolerance_m_;
    std::vector<bool> in_patch_;
};

}  // namespace

std::size_t join_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress)
{
    return Joiner(surface, flat, texel_m).run(progress);
}

}  // namespace fresco::geometry
