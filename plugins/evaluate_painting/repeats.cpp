#include "repeats.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <utility>

using namespace fresco;

namespace
{

constexpr double points_per_stroke = 4;
constexpr float same_place = 0.5F;  // Strokes, as all lengths.
constexpr float nearest = 1.5F;
constexpr float farthest = 10;
constexpr float nearest_woven = 0.25F;
constexpr float farthest_woven = 2.5F;
constexpr float same_woven = 0.2F;
constexpr float opposite = 0.2F;  // Of the sum of two distances.
constexpr std::size_t points_per_piece = 1024;

/// Per pixel whether the standard deviation of L*a*b* within about a stroke is above the picture's median.
Raster8 motifs(const Raster8& picture, double stroke_px)
{
    const RasterF variance = local_variance(lab_picture(picture), stroke_px / 2);
    std::vector<float> sorted = variance.values;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    Raster8 result(variance.width, variance.height);
    std::ranges::transform(variance.values, result.values.begin(),
                           [&](float v) { return v > *middle ? std::uint8_t{1} : std::uint8_t{0}; });
    return result;
}

}  // namespace

std::vector<CopiedPoint> copied_points(const SourceMap& source, const Mesh& mesh, const Raster8& picture,
                                       const Progress& progress)
{
    if (source.picture_width != picture.width || source.picture_height != picture.height)
        throw Error(
            fmt::format("the map on port 'source' has places in a picture of {} x {}, the one on port 'style' is {} x {}: wire "
                        "the picture that the room was painted with",
                        source.picture_width, source.picture_height, picture.width, picture.height));
    const texturing::TexelFaces faces =
        texturing::find_texel_faces(mesh, texturing::find_charts(mesh), source.size_px(), progress);
    const double texel_m = texturing::mean_texel_m(mesh, source.size_px());
    if (texel_m == 0)
        throw Error("the mesh on port 'textured_mesh' has no area: its repeats cannot be measured");
    const double stroke_px = stroke_width_px(picture, progress);
    const double stroke_texels = stroke_px / source.pixels_per_texel;
    const double stroke_m = stroke_texels * texel_m;
    const Raster8 is_motif = motifs(picture, stroke_px);
    const int step = std::max(1, static_cast<int>(stroke_texels / points_per_stroke));
    std::vector<CopiedPoint> points;
    for (int y = 0; y < source.size_px(); y += step)
        for (int x = 0; x < source.size_px(); x += step)
        {
            const std::size_t texel =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(source.size_px()) + static_cast<std::size_t>(x);
            const auto place = source.place(x, y);
            if (!place || !faces.covered(texel) || faces.inside[texel] == 0)
                continue;
            const auto pixel = [](float at, int count) { return std::clamp(static_cast<int>(at), 0, count - 1); };
            points.push_back({texturing::texel_position(mesh, faces, texel) * static_cast<float>(1 / stroke_m),
                              place->at * static_cast<float>(1 / stroke_px), place->scale,
                              is_motif.at(pixel(place->at.x, picture.width), pixel(place->at.y, picture.height)) != 0});
        }
    return points;
}

namespace
{

/// A square of the picture that is half a stroke wide, at one scale: scale, y and x.
using PlaceCell = std::array<int, 3>;

PlaceCell place_cell(const CopiedPoint& point)
{
    const auto number = [](float v) { return static_cast<int>(std::floor(v / same_place)); };
    return {static_cast<int>(std::lround(std::log2(point.scale))), number(point.place.y), number(point.place.x)};
}

/// The points of one cell.
struct CellPoints
{
    std::span<const CopiedPoint> points;
    Vec2f middle;  ///< Of the cell, in the picture.

    /// Squared distance of a place from the cell; 0 inside.
    float distance_squared(Vec2f place) const
    {
        const auto outside = [](float away) { return std::max(std::abs(away) - same_place / 2, 0.0F); };
        const Vec2f away{outside(place.x - middle.x), outside(place.y - middle.y)};
        return dot(away, away);
    }
};

using NearbyCells = std::vector<CellPoints>;

/// Points by their place in the picture, and those of one cell by their x on the surface.
class PointsByPlace
{
  public:
    explicit PointsByPlace(std::span<const CopiedPoint> points)
    {
        std::vector<std::pair<PlaceCell, std::uint32_t>> sorted;
        sorted.reserve(points.size());
        for (std::uint32_t i = 0; i < points.size(); ++i)
            sorted.emplace_back(place_cell(points[i]), i);
        std::ranges::sort(sorted, [&](const auto& a, const auto& b)
                          { return a.first != b.first ? a.first < b.first : points[a.second].at.x < points[b.second].at.x; });
        points_.reserve(points.size());
        for (const auto& [cell, index] : sorted)
        {
            if (cells_.empty() || cells_.back() != cell)
            {
                cells_.push_back(cell);
                first_.push_back(points_.size());
            }
            points_.push_back(points[index]);
        }
        first_.push_back(points_.size());
    }

    /// Calls visit(point, the cells around its place in the picture) for points from `begin` to before `end`, in their order
    /// here.
    template <class Visit>
    void for_each(std::size_t begin, std::size_t end, const Visit& visit) const
    {
        auto cell = static_cast<std::size_t>(std::ranges::upper_bound(first_, begin) - first_.begin()) - 1;
        for (; begin < end; ++cell)
        {
            const NearbyCells nearby = near(cells_[cell]);
            for (const std::size_t last = std::min(end, first_[cell + 1]); begin < last; ++begin)
                visit(points_[begin], nearby);
        }
    }

  private:
    /// The cell and the eight around it, where there are points from them.
    NearbyCells near(const PlaceCell& middle) const
    {
        NearbyCells nearby;
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
            {
                const PlaceCell wanted{middle[0], middle[1] + y, middle[2] + x};
                const auto found = std::ranges::lower_bound(cells_, wanted);
                if (found == cells_.end() || *found != wanted)
                    continue;
                const auto cell = static_cast<std::size_t>(found - cells_.begin());
                const auto center = [](int number) { return (static_cast<float>(number) + 0.5F) * same_place; };
                nearby.push_back({std::span(points_).subspan(first_[cell], first_[cell + 1] - first_[cell]),
                                  {center(wanted[2]), center(wanted[1])}});
            }
        return nearby;
    }

    std::vector<CopiedPoint> points_;
    std::vector<PlaceCell> cells_;
    std::vector<std::size_t> first_;  ///< Index of each cell's first point, then the number of points.
};

/// Calls visit(step to it, its distance on the surface, its distance in the picture) for at least the points within `reach` on
/// the surface, in strokes of the point's scale, and `most_apart` in the picture, and for some beyond. Returns true once `visit`
/// does.
template <class Visit>
bool any_near(const CopiedPoint& point, const NearbyCells& nearby, float reach, float most_apart, const Visit& visit)
{
    constexpr float slack = 1.0001F;  // Distances are rounded; `visit` compares them itself.
    const float margin = slack * reach / point.scale;
    for (const CellPoints& cell : nearby)
    {
        if (cell.distance_squared(point.place) > slack * most_apart * most_apart)
            continue;
        auto other = std::ranges::lower_bound(cell.points, point.at.x - margin, {}, [](const CopiedPoint& p) { return p.at.x; });
        for (; other != cell.points.end() && other->at.x <= point.at.x + margin; ++other)
        {
            const Vec3f step = other->at - point.at;
            if (std::abs(step.y) <= margin && std::abs(step.z) <= margin &&
                visit(step, length(step) * point.scale, length(other->place - point.place)))
                return true;
        }
    }
    return false;
}

bool is_repeated(const CopiedPoint& point, const NearbyCells& nearby)
{
    return point.is_motif && any_near(point, nearby, farthest, same_place,
                                      [](Vec3f, float on_surface, float in_picture)
                                      { return on_surface > nearest && on_surface < farthest && in_picture < same_place; });
}

bool is_woven(const CopiedPoint& point, const NearbyCells& nearby)
{
    std::vector<Vec3f> steps;
    return any_near(
        point, nearby, farthest_woven, same_woven,
        [&](Vec3f step, float on_surface, float in_picture)
        {
            if (on_surface < nearest_woven || on_surface > farthest_woven || in_picture > std::min(same_woven, on_surface / 4))
                return false;
            steps.push_back(step);
            return std::ranges::any_of(steps, [&](Vec3f s) { return length(s + step) < opposite * (length(s) + length(step)); });
        });
}

}  // namespace

Repeats repeats(std::span<const CopiedPoint> points, const Progress& progress)
{
    const PointsByPlace by_place(points);
    std::atomic<std::size_t> repeated{0};
    std::atomic<std::size_t> woven{0};
    parallel_for(points.size(), points_per_piece, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     by_place.for_each(begin, end,
                                       [&](const CopiedPoint& point, const NearbyCells& nearby)
                                       {
                                           repeated += is_repeated(point, nearby) ? 1 : 0;
                                           woven += is_woven(point, nearby) ? 1 : 0;
                                       });
                 });
    const auto share = [&](std::size_t count)
    { return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, points.size())); };
    return {share(repeated), share(woven)};
}
