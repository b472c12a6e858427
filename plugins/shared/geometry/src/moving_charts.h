#pragma once

#include <fresco/geometry/flatten.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace fresco::geometry
{

using FaceList = std::vector<std::uint32_t>;

/// A chart of at most this many faces may be a crumb: noise of the scan, which may go into another chart.
inline constexpr std::size_t crumb_faces = 64;

/// Up to what size a chart is a crumb.
struct CrumbLimits
{
    std::size_t faces = crumb_faces;
    double area_m2 = 0;
};

/// Flat charts whose faces change places: who has which faces, and where each lies. Refers to both, which must outlive it;
/// changes `flat` alone. Not thread-safe.
class MovingCharts
{
  public:
    MovingCharts(const Surface& surface, FlatCharts& flat);

    const Surface& surface() const { return surface_; }
    const FlatCharts& flat() const { return flat_; }
    const FaceList& faces(std::uint32_t chart) const { return faces_[chart]; }
    bool is_crumb(std::uint32_t chart, const CrumbLimits& limits) const;
    /// All crumbs, those of the fewest faces first.
    std::vector<std::uint32_t> crumbs(const CrumbLimits& limits) const;
    /// The charts of no fewer faces that share edges with this one, longest common border first.
    std::vector<std::uint32_t> neighbors(std::uint32_t chart) const;

    /// Where a face, which has this vertex, has it: an index into the flat corners.
    std::size_t corner(std::uint32_t face, std::uint32_t vertex) const
    {
        const auto& t = surface_.mesh.triangles[face];
        return 3 * std::size_t{face} + (t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2);
    }
    Vec2d place(std::uint32_t face, std::uint32_t vertex) const { return flat_.corners[corner(face, vertex)]; }

    /// Whether a triangle lies deeper than `tolerance` on a face of the chart for which `counts(face)` holds.
    template <class Counts>
    bool covered(std::uint32_t chart, std::span<const Vec2d, 3> triangle, double tolerance, Counts counts) const;

    /// Lays a face again, in this chart.
    void lay(std::uint32_t face, std::uint32_t chart, std::span<const Vec2d, 3> corners);
    /// Notes that all faces of a crumb were laid in a chart.
    void dissolve(std::uint32_t crumb, std::uint32_t chart);

  private:
    using Key = std::uint64_t;
    template <class Act>
    void each_cell(std::uint32_t chart, std::span<const Vec2d, 3> triangle, Act act) const;
    std::span<const Vec2d, 3> triangle(std::uint32_t face) const
    {
        return std::span<const Vec2d, 3>(flat_.corners.data() + 3 * std::size_t{face}, 3);
    }
    void enter(std::uint32_t face);

    const Surface& surface_;
    FlatCharts& flat_;
    std::vector<FaceList> faces_;  ///< By chart.
    double cell_m_;
    /// Faces by the cells of their chart that their boxes touch. A face that moves is entered again and stays where it was: it is
    /// always looked at where it is now.
    std::unordered_map<Key, FaceList> cells_;
};

template <class Act>
void MovingCharts::each_cell(std::uint32_t chart, std::span<const Vec2d, 3> t, Act act) const
{
    const auto bin = [&](double value) { return static_cast<std::int64_t>(std::floor(value / cell_m_)); };
    const auto [x_low, x_high] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [y_low, y_high] = std::minmax({t[0].y, t[1].y, t[2].y});
    for (auto y = bin(y_low); y <= bin(y_high); ++y)
        for (auto x = bin(x_low); x <= bin(x_high); ++x)
            act((static_cast<Key>(chart) << 36) ^ (static_cast<Key>(y & 0x3ffff) << 18) ^ static_cast<Key>(x & 0x3ffff));
}

template <class Counts>
bool MovingCharts::covered(std::uint32_t chart, std::span<const Vec2d, 3> corners, double tolerance, Counts counts) const
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

}  // namespace fresco::geometry
