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

/// Points by their place in the picture, and those of one cell by their x on the surface.
class PointsByPlace
{
  public:
    explicit PointsByPlace(std::span<const CopiedPoint> points) : points_(points.begin(), points.end())
    {
        std::ranges::sort(points_, {}, [](const CopiedPoint& p) { return std::pair(place_cell(p), p.at.x); });
        for (std::size_t i = 0; i < points_.size(); ++i)
            if (const PlaceCell cell = place_cell(points_[i]); cells_.empty() || cells_.back() != cell)
            {
                cells_.push_back(cell);
                first_.push_back(i);
            }
        first_.push_back(points_.size());
    }

    const std::vector<CopiedPoint>& points() const { return points_; }

    /// Calls visit(other, distance on the surface, distance in the picture) for points of about the same place, in strokes of the
    /// point's scale, until it returns true.
    template <class Visit>
    bool any_near(const CopiedPoint& point, float reach, const Visit& visit) const
    {
        const auto [scale, middle_y, middle_x] = place_cell(point);
        for (int y = middle_y - 1; y <= middle_y + 1; ++y)
            for (int x = middle_x - 1; x <= middle_x + 1; ++x)
            {
                const PlaceCell wanted{scale, y, x};
                const auto found = std::ranges::lower_bound(cells_, wanted);
                if (found == cells_.end() || *found != wanted)
                    continue;
                const auto cell = static_cast<std::size_t>(found - cells_.begin());
                const auto in_cell = std::span(points_).subspan(first_[cell], first_[cell + 1] - first_[cell]);
                const float margin = reach / point.scale;
                for (auto other =
                         std::ranges::lower_bound(in_cell, point.at.x - margin, {}, [](const CopiedPoint& p) { return p.at.x; });
                     other != in_cell.end() && other->at.x <= point.at.x + margin; ++other)
                    if (visit(*other, length(other->at - point.at) * point.scale, length(other->place - point.place)))
                        return true;
            }
        return false;
    }

  private:
    std::vector<CopiedPoint> points_;
    std::vector<PlaceCell> cells_;
    std::vector<std::size_t> first_;
};

bool is_repeated(const PointsByPlace& points, const CopiedPoint& point)
{
    return point.is_motif && points.any_near(point, farthest,
                                             [](const CopiedPoint&, float on_surface, float in_picture) {
                                                 return on_surface > nearest && on_surface < farthest && in_picture < same_place;
                                             });
}

bool is_woven(const PointsByPlace& points, const CopiedPoint& point)
{
    std::vector<Vec3f> steps;
    return points.any_near(
        point, farthest_woven,
        [&](const CopiedPoint& other, float on_surface, float in_picture)
        {
            if (on_surface < nearest_woven || on_surface > farthest_woven || in_picture > std::min(same_woven, on_surface / 4))
                return false;
            const Vec3f step = other.at - point.at;
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
    parallel_items(points.size(), points_per_piece, progress,
                   [&](std::size_t i)
                   {
                       const CopiedPoint& point = by_place.points()[i];
                       repeated += is_repeated(by_place, point) ? 1 : 0;
                       woven += is_woven(by_place, point) ? 1 : 0;
                   });
    const auto share = [&](std::size_t count)
    { return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, points.size())); };
    return {share(repeated), share(woven)};
}
