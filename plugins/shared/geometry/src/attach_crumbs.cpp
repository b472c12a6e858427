#include "moving_charts.h"

#include <array>
#include <map>

namespace fresco::geometry
{

namespace
{

/// Charts of more texels stay where they are.
constexpr double attached_texels = 256;
/// A crumb may be laid out larger or smaller by this factor, to fit the edge that it joins at.
constexpr double largest_scale = 1.25;
/// Edges that are tried for each neighboring chart, the longest ones.
constexpr std::size_t tried_edges = 3;
constexpr int rounds = 4;

/// Moves points of one plane to another: z -> turn * z + shift in complex numbers, so that shapes stay.
struct Similarity
{
    Vec2d turn, shift;
    Vec2d operator()(Vec2d p) const { return {turn.x * p.x - turn.y * p.y + shift.x, turn.y * p.x + turn.x * p.y + shift.y}; }
    /// Takes a to a_there and b to b_there; a and b differ.
    static Similarity between(Vec2d a, Vec2d b, Vec2d a_there, Vec2d b_there)
    {
        const Vec2d from = b - a;
        const Vec2d to = b_there - a_there;
        const double squared = dot(from, from);
        const Vec2d turn{dot(from, to) / squared, cross(from, to) / squared};
        const Similarity still{turn, {}};
        return {turn, a_there - still(a)};
    }
};

class Attacher
{
  public:
    Attacher(const Surface& surface, FlatCharts& flat, double texel_m)
        : charts_(surface, flat), limits_{.area_m2 = attached_texels * texel_m * texel_m}, tolerance_m_(1e-3 * texel_m)
    {
    }

    /// Returns how many crumbs found a place.
    std::size_t round(const Progress& progress)
    {
        std::size_t placed = 0;
        for (const auto crumb : charts_.crumbs(limits_))
        {
            progress.check_canceled();
            if (charts_.is_crumb(crumb, limits_) && place(crumb))
                ++placed;
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
            std::stable_sort(edges.begin(), edges.end(), [](const Seam& a, const Seam& b) { return a.length_m > b.length_m; });
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
        const auto a_there = charts_.place(seam.other, a);
        const auto b_there = charts_.place(seam.other, b);
        const double scale = length(b_there - a_there) / seam.length_m;
        if (!(scale <= largest_scale && scale >= 1 / largest_scale))
            return false;
        const auto moved = Similarity::between(charts_.place(seam.face, a), charts_.place(seam.face, b), a_there, b_there);
        std::vector<std::array<Vec2d, 3>> corners;
        corners.reserve(charts_.faces(crumb).size());
        for (const std::uint32_t f : charts_.faces(crumb))
        {
            const auto* corner = &charts_.flat().corners[3 * std::size_t{f}];
            corners.push_back({moved(corner[0]), moved(corner[1]), moved(corner[2])});
            if (charts_.covered(chart, corners.back(), tolerance_m_, [](std::uint32_t) { return true; }))
                return false;
        }
        for (std::size_t i = 0; i < corners.size(); ++i)
            charts_.lay(charts_.faces(crumb)[i], chart, corners[i]);
        charts_.dissolve(crumb, chart);
        return true;
    }

    MovingCharts charts_;
    CrumbLimits limits_;
    double tolerance_m_;
};

}  // namespace

std::size_t attach_crumbs(const Surface& surface, FlatCharts& flat, double texel_m, const Progress& progress)
{
    Attacher attacher(surface, flat, texel_m);
    std::size_t placed = 0;
    for (int i = 0; i < rounds; ++i)
    {
        const std::size_t now = attacher.round(progress);
        placed += now;
        if (now == 0)
            break;
    }
    return placed;
}

}  // namespace fresco::geometry
