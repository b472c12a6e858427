#include <fresco/geometry/flatten.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

namespace fresco::geometry
{

namespace
{

/// Charts of more faces, or of more texels, stay where they are.
constexpr std::size_t crumb_faces = 64;
constexpr double crumb_texels = 256;
/// A crumb may be laid out larger or smaller by this factor, to fit the edge that it joins at.
constexpr double largest_scale = 1.25;
/// Edges that are tried for each neighbouring chart, the longest ones.
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

/// The faces of all charts by the cells of a grid that their boxes touch.
class Cells
{
  public:
    Cells(const Corners& corners, double cell_m) : corners_(corners), cell_(cell_m) {}

    void add(std::uint32_t chart, std::uint32_t face)
    {
        each_cell(chart, triangle(corners_, face), [&](std::uint64_t key) { faces_[key].push_back(face); });
    }
    /// Whether the triangle lies on a face of the chart.
    bool covered(std::uint32_t chart, std::span<const Vec2d, 3> corners, double tolerance) const
    {
        bool found = false;
        each_cell(chart, corners,
                  [&](std::uint64_t key)
                  {
                      const auto cell = faces_.find(key);
                      if (cell == faces_.end() || found)
                          return;
                      for (const std::uint32_t face : cell->second)
                          found = found || overlap_depth(corners, triangle(corners_, face)) > tolerance;
                  });
        return found;
    }

  private:
    static std::span<const Vec2d, 3> triangle(const Corners& corners, std::uint32_t face)
    {
        return std::span<const Vec2d, 3>(corners.data() + 3 * std::size_t{face}, 3);
    }
    template <class Act>
    void each_cell(std::uint32_t chart, std::span<const Vec2d, 3> t, Act act) const
    {
        const auto bin = [&](double value) { return static_cast<std::int64_t>(std::floor(value / cell_)); };
        const auto [x_low, x_high] = std::minmax({t[0].x, t[1].x, t[2].x});
        const auto [y_low, y_high] = std::minmax({t[0].y, t[1].y, t[2].y});
        for (auto y = bin(y_low); y <= bin(y_high); ++y)
            for (auto x = bin(x_low); x <= bin(x_high); ++x)
                act((static_cast<std::uint64_t>(chart) << 36) ^ (static_cast<std::uint64_t>(y & 0x3ffff) << 18) ^
                    static_cast<std::uint64_t>(x & 0x3ffff));
    }

    const Corners& corners_;
    double cell_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> faces_;
};

class Attacher
{
  public:
    Attacher(const Surface& surface, FlatCharts& flat, double texel_m)
        : surface_(surface), flat_(flat), tolerance_(1e-3 * texel_m), largest_area_(crumb_texels * texel_m * texel_m),
          faces_(Partition{flat.chart_of_face, flat.axes}.faces()), cells_(flat.corners, cell_size())
    {
        for (std::uint32_t c = 0; c < faces_.size(); ++c)
            for (const std::uint32_t f : faces_[c])
                cells_.add(c, f);
    }

    /// Returns how many crumbs found a place.
    std::size_t round(const Progress& progress)
    {
        std::vector<std::uint32_t> order;
        for (std::uint32_t c = 0; c < faces_.size(); ++c)
            if (is_crumb(c))
                order.push_back(c);
        std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return faces_[a].size() < faces_[b].size(); });
        std::size_t placed = 0;
        for (const std::uint32_t c : order)
        {
            progress.check_cancelled();
            if (is_crumb(c) && place(c))
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

    bool is_crumb(std::uint32_t chart) const
    {
        double area = 0;
        for (const std::uint32_t f : faces_[chart])
            area += surface_.areas[f];
        return !faces_[chart].empty() && faces_[chart].size() <= crumb_faces && area <= largest_area_;
    }

    double cell_size() const
    {
        double sum = 0;
        for (std::size_t f = 0; f < surface_.areas.size(); ++f)
            sum += length(flat_.corners[3 * f + 1] - flat_.corners[3 * f]);
        return std::max(1.5 * sum / static_cast<double>(std::max<std::size_t>(surface_.areas.size(), 1)), 1e-9);
    }

    bool place(std::uint32_t crumb)
    {
        std::map<std::uint32_t, std::vector<Seam>> seams;
        for (const std::uint32_t f : faces_[crumb])
            for (std::uint32_t k = 0; k < 3; ++k)
                if (const auto g = surface_.neighbours[f][k]; g != none && flat_.chart_of_face[g] != crumb)
                    seams[flat_.chart_of_face[g]].push_back(
                        {f, k, g, length(flat_.corners[3 * f + (k + 1) % 3] - flat_.corners[3 * f + k])});
        std::vector<std::pair<double, std::uint32_t>> targets;
        for (auto& [chart, edges] : seams)
        {
            double sum = 0;
            for (const Seam& edge : edges)
                sum += edge.length_m;
            // The longest common border first.
            if (faces_[chart].size() >= faces_[crumb].size())
                targets.emplace_back(-sum, chart);
            std::stable_sort(edges.begin(), edges.end(), [](const Seam& a, const Seam& b) { return a.length_m > b.length_m; });
        }
        std::sort(targets.begin(), targets.end());
        for (const auto& [negative, chart] : targets)
            for (std::size_t i = 0; i < std::min(tried_edges, seams[chart].size()); ++i)
                if (place_at(crumb, chart, seams[chart][i]))
                    return true;
        return false;
    }

    Vec2d corner_of(std::uint32_t face, std::uint32_t vertex) const
    {
        const auto& t = surface_.mesh.triangles[face];
        const std::size_t k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
        return flat_.corners[3 * std::size_t{face} + k];
    }

    bool place_at(std::uint32_t crumb, std::uint32_t chart, const Seam& seam)
    {
        const auto& t = surface_.mesh.triangles[seam.face];
        const Vec2d a_there = corner_of(seam.other, t[seam.corner]);
        const Vec2d b_there = corner_of(seam.other, t[(seam.corner + 1) % 3]);
        const double scale = length(b_there - a_there) / seam.length_m;
        if (!(scale <= largest_scale && scale >= 1 / largest_scale))
            return false;
        const auto moved =
            Similarity::between(flat_.corners[3 * std::size_t{seam.face} + seam.corner],
                                flat_.corners[3 * std::size_t{seam.face} + (seam.corner + 1) % 3], a_there, b_there);
        std::vector<Vec2d> corners;
        corners.reserve(3 * faces_[crumb].size());
        for (const std::uint32_t f : faces_[crumb])
        {
            for (std::size_t k = 0; k < 3; ++k)
                corners.push_back(moved(flat_.corners[3 * std::size_t{f} + k]));
            if (cells_.covered(chart, std::span<const Vec2d, 3>(corners.data() + corners.size() - 3, 3), tolerance_))
                return false;
        }
        // Its old faces stay in the cells of a chart that is gone: nothing asks for them.
        for (std::size_t i = 0; i < faces_[crumb].size(); ++i)
        {
            const std::uint32_t f = faces_[crumb][i];
            std::copy_n(corners.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                        flat_.corners.begin() + static_cast<std::ptrdiff_t>(3 * std::size_t{f}));
            flat_.chart_of_face[f] = chart;
            flat_.projected[f] = 0;
            ++flat_.unfolded_faces;
            cells_.add(chart, f);
        }
        faces_[chart].insert(faces_[chart].end(), faces_[crumb].begin(), faces_[crumb].end());
        faces_[crumb].clear();
        return true;
    }

    const Surface& surface_;
    FlatCharts& flat_;
    double tolerance_;
    double largest_area_;
    std::vector<std::vector<std::uint32_t>> faces_;
    Cells cells_;
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
