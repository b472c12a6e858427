#include "relief.h"

#include <fresco/images/lab.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/surface_average.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

constexpr double strokes_per_wavelength = 4;  // A stroke and the next are a wave of two; half of one of four is left.
constexpr double usual = 2;                   // Differences of so many times the root mean square begin to saturate.
constexpr double canvas_roughness = 0.85;
constexpr double paint_roughness = 0.4;
constexpr std::size_t texels_per_block = 1U << 16U;

/// Calls visit(texel, mean) for each texel that a face covers; rows are shared among threads.
template <class Visit>
void visit_means(const TexelMeans& means, double wavelength_m, const TexelFaces& faces, const Progress& progress,
                 const Visit& visit)
{
    means.each_row(wavelength_m, "stroke_cm", progress,
                   [&](std::size_t row, const std::vector<float>& mean)
                   {
                       for (std::size_t at = 0; at < mean.size(); at += 3)
                           if (const std::size_t texel = (row * mean.size() + at) / 3; faces.covered(texel))
                               visit(texel, &mean[at]);
                   });
}

/// The largest value of the covered texels beside this one; 0 without any.
float largest_around(const RasterF& values, const TexelFaces& faces, std::size_t texel)
{
    const int x = static_cast<int>(texel) % faces.size, y = static_cast<int>(texel) / faces.size;
    float largest = 0;
    for (int row = std::max(y - 1, 0); row <= std::min(y + 1, faces.size - 1); ++row)
        for (int column = std::max(x - 1, 0); column <= std::min(x + 1, faces.size - 1); ++column)
            if (const auto at = static_cast<std::size_t>(row * faces.size + column); faces.covered(at))
                largest = std::max(largest, values.values[at]);
    return largest;
}

}  // namespace

RasterF paint_height(const Raster8& rgb, const Mesh& mesh, const TexelFaces& faces, double height_m, double stroke_m,
                     const Progress& progress)
{
    const auto light = [&](std::size_t texel) { return static_cast<float>(luma(&rgb.values[3 * texel])); };
    const TexelMeans means(mesh, faces, [&](std::size_t texel) { return Vec3f{light(texel), 0, 0}; });
    RasterF height(faces.size, faces.size);
    const auto size = static_cast<std::size_t>(faces.size);
    std::vector<double> squares(size, 0);
    visit_means(means, strokes_per_wavelength * stroke_m, faces, progress,
                [&](std::size_t texel, const float* mean)
                {
                    const float detail = light(texel) - mean[0];
                    height.values[texel] = detail;
                    squares[texel / size] += faces.inside[texel] * double{detail} * double{detail};
                });
    double sum = 0;
    for (const double row : squares)
        sum += row;
    const auto texels = std::max<std::ptrdiff_t>(std::count(faces.inside.begin(), faces.inside.end(), std::uint8_t{1}), 1);
    // At least a step of the picture, so that a surface of one color is flat.
    const double soft = usual * std::max(std::sqrt(sum / static_cast<double>(texels)), 1.0);
    parallel_items(height.values.size(), texels_per_block, progress,
                   [&](std::size_t texel)
                   {
                       const double detail = double{height.values[texel]};
                       if (faces.covered(texel))
                           height.values[texel] = static_cast<float>(height_m * 0.5 * (1 + detail / std::hypot(detail, soft)));
                   });
    return height;
}

RasterF strokes_shown(const Raster8& painting, const Raster8& copied, const SourceMap& source, const Mesh& mesh,
                      const TexelFaces& faces, double stroke_m, const Progress& progress)
{
    // Measured: 99 % of painted texels correlate above 0.92 with their own picture and keep 0.74 of its contrast; 99 % of a
    // photo's stay below 0.86.
    constexpr double unlike = 0.85;
    constexpr double alike = 0.92;
    constexpr double least_contrast = 0.65;
    constexpr float noise = 4;  // Steps of the picture, squared: plain paint is like any plain surface.
    const int size = faces.size;
    const auto lights = [&](std::size_t texel)
    {
        const auto along = [&](std::size_t at) { return static_cast<int>(at) * source.size_px() / size; };
        const auto side = static_cast<std::size_t>(size);
        const auto place = source.place(along(texel % side), along(texel / side));
        const Vec3f shift = place ? place->shift * 255 : Vec3f{};
        return Vec3f{static_cast<float>(luma(&copied.values[3 * texel])) + dot(shift, Vec3f{0.299F, 0.587F, 0.114F}),
                     static_cast<float>(luma(&painting.values[3 * texel])), 0};
    };
    const TexelMeans means(mesh, faces, lights);
    RasterF details(size, size, 3);
    visit_means(
        means, strokes_per_wavelength * stroke_m, faces, progress,
        [&](std::size_t texel, const float* mean)
        {
            const Vec3f light = lights(texel);
            const float picture = light.x - mean[0], painted = light.y - mean[1];
            std::ranges::copy(std::array{picture * picture, painted * painted, picture * painted}, &details.values[3 * texel]);
        });
    const TexelMeans products(mesh, faces,
                              [&](std::size_t texel)
                              {
                                  const float* const v = &details.values[3 * texel];
                                  return Vec3f{v[0], v[1], v[2]};
                              });
    RasterF shown(size, size);
    visit_means(products, 2 * strokes_per_wavelength * stroke_m, faces, progress,
                [&](std::size_t texel, const float* mean)
                {
                    const double picture = double{mean[0] + noise}, painted = double{mean[1] + noise};
                    const double both = double{mean[2] + noise};
                    const double likeness = (both / std::sqrt(picture * painted) - unlike) / (alike - unlike);
                    const double contrast = both / picture / least_contrast;
                    shown.values[texel] = static_cast<float>(std::clamp(likeness, 0.0, 1.0) * std::clamp(contrast, 0.0, 1.0));
                });
    for (std::size_t texel = 0; texel < shown.values.size(); ++texel)
        if (!faces.covered(texel))
            shown.values[texel] = largest_around(shown, faces, texel);
    return shown;
}

void keep_shown(Relief& relief, const RasterF& shown)
{
    for (std::size_t texel = 0; texel < shown.values.size(); ++texel)
    {
        const double share = double{shown.values[texel]};
        std::uint8_t& roughness = relief.roughness.values[texel];
        if (relief.has_normal(texel))
            roughness = static_cast<std::uint8_t>(
                std::lround(255 * canvas_roughness * (1 - share) + share * static_cast<double>(roughness)));
    }
}

namespace
{

/// A face's frame and its duals: a vector along the face is dot(vector, across) texels to the right and dot(vector, along) down.
/// They are zero for a face without area, in space or in the texture.
struct DualFrame : FaceFrame
{
    Vec3d across, along;

    DualFrame(const Mesh& mesh, std::uint32_t face, int size) : FaceFrame(mesh, face, size)
    {
        const double rr = dot(right, right), rd = dot(right, down), dd = dot(down, down);
        const double determinant = rr * dd - rd * rd;
        if (!(determinant > 1e-12 * rr * dd))
            return;
        across = (right * dd - down * rd) * (1 / determinant);
        along = (down * rr - right * rd) * (1 / determinant);
    }

    bool is_flat() const { return dot(across, across) == 0; }
    Vec3d in_space(Vec2d texels) const { return right * texels.x + down * texels.y; }
    Vec2d in_texels(Vec3d v) const { return {dot(v, across), dot(v, along)}; }
};

/// A texel past the border of a chart, and where the surface goes on.
struct Continued
{
    std::uint32_t texel;
    double distance;      ///< Distance from the border, in texels, squared.
    std::uint32_t chart;  ///< Chart that the border belongs to.
    std::uint32_t other;  ///< The chart that goes on there …
    Vec2d at;             ///< … at this place, in texels.
    bool operator<(const Continued& b) const
    {
        return std::tie(texel, distance, chart, other, at.x, at.y) <
               std::tie(b.texel, b.distance, b.chart, b.other, b.at.x, b.at.y);
    }
};

/// The charts' texels, and those around them that continue the surface across seams: one more along their borders.
class Surface
{
  public:
    Surface(const Mesh& mesh, const Charts& charts, const TexelFaces& faces, const Progress& progress)
        : mesh_(mesh), charts_(charts), faces_(faces), progress_(progress), chart_(faces.face.size(), TexelFaces::none)
    {
        for (std::size_t texel = 0; texel < chart_.size(); ++texel)
            if (faces.inside[texel])
                chart_[texel] = charts.of_face[faces.face[texel]];
        for (const Seam& seam : charts.seams)
        {
            progress_.check_canceled();
            add_border(seam.first_face, seam.first, seam.second_face, seam.second);
            add_border(seam.second_face, seam.second, seam.first_face, seam.first);
        }
        std::ranges::sort(ring_, std::less<>());
        const auto twice = std::ranges::unique(ring_, {}, &Continued::texel);
        ring_.erase(twice.begin(), twice.end());
    }

    /// The chart of a texel, its own or whose border it is at; none elsewhere.
    std::uint32_t chart(std::size_t texel) const { return chart_[texel]; }

    /// Sets values at the texels past the borders from those at the places where they continue: `value`(texel) of the texels
    /// around, weighted, is what `set`(texel, value) puts there. `T`: a vector, or a number.
    template <class T, class Value, class Set>
    void continue_values(const Value& value, const Set& set)
    {
        for (const Continued& past : ring_)
            chart_[past.texel] = TexelFaces::none;
        // The first time the places next to borders know only one side.
        for (int round = 0; round < 8; ++round)
        {
            progress_.check_canceled();
            std::vector<std::optional<T>> found(ring_.size());
            for (std::size_t i = 0; i < ring_.size(); ++i)
                found[i] = around<T>(ring_[i], value);
            for (std::size_t i = 0; i < ring_.size(); ++i)
                if (found[i])
                {
                    set(ring_[i].texel, *found[i]);
                    chart_[ring_[i].texel] = ring_[i].chart;
                }
        }
    }

  private:
    std::size_t number(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(x);
    }
    bool exists(int x, int y) const { return x >= 0 && y >= 0 && x < faces_.size && y < faces_.size; }

    template <class T, class Value>
    std::optional<T> around(const Continued& place, const Value& value) const
    {
        const int left = static_cast<int>(std::floor(place.at.x - 0.5));
        const int top = static_cast<int>(std::floor(place.at.y - 0.5));
        T sum{};
        double total = 0;
        for (int y = top; y <= top + 1; ++y)
            for (int x = left; x <= left + 1; ++x)
                if (exists(x, y) && chart_[number(x, y)] == place.other)
                {
                    const double weight = (1 - std::abs(place.at.x - 0.5 - x)) * (1 - std::abs(place.at.y - 0.5 - y));
                    sum = sum + value(number(x, y)) * weight;
                    total += weight;
                }
        return total > 0.01 ? std::optional(sum * (1 / total)) : std::nullopt;
    }

    /// Direction into a face, square to its side from `a` to `b`.
    static Vec3d inward(const DualFrame& face, Vec3d a, Vec3d direction)
    {
        const Vec3d to_middle = (face.points[0] + face.points[1] + face.points[2]) * (1.0 / 3) - a;
        return normalized(to_middle - direction * dot(to_middle, direction));
    }

    void add_border(std::uint32_t own_face, const std::array<Vec2f, 2>& own_side, std::uint32_t other_face,
                    const std::array<Vec2f, 2>& other_side)
    {
        const DualFrame own(mesh_, own_face, faces_.size);
        const DualFrame other(mesh_, other_face, faces_.size);
        if (own.is_flat() || other.is_flat())
            return;
        const auto texels = [&](Vec2f uv) { return Vec2d{double{uv.x} * faces_.size, (1 - double{uv.y}) * faces_.size}; };
        const Vec2d begin = texels(own_side[0]), end = texels(own_side[1]);
        const Vec2d side = end - begin;
        const Vec3d in_space = own.in_space(side);
        if (!(length(in_space) > 0))
            return;
        // Both faces laid flat: what is beyond the one is on the other, as far from the side.
        const Vec3d direction = normalized(in_space);
        const Vec3d corner = own.points[0] + own.in_space(begin - own.corners[0]);
        const Vec3d outward = -inward(own, corner, direction);
        const Vec3d onward = inward(other, corner, direction);
        const auto place = [&](Vec2d at)
        {
            const Vec3d v = own.in_space(at - begin);
            return texels(other_side[0]) + other.in_texels(direction * dot(v, direction) + onward * dot(v, outward));
        };
        const std::uint32_t chart = charts_.of_face[own_face];
        const int steps = 1 + static_cast<int>(2 * length(side));
        std::uint32_t last = TexelFaces::none;
        for (int i = 0; i <= steps; ++i)
        {
            const Vec2d at = begin + side * (static_cast<double>(i) / steps);
            const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
            const auto here = static_cast<std::uint32_t>(exists(x, y) ? number(x, y) : TexelFaces::none);
            if (here == last)
                continue;
            last = here;
            for (int row = y - 1; row <= y + 1; ++row)
                for (int column = x - 1; column <= x + 1; ++column)
                {
                    if (!exists(column, row) || faces_.inside[number(column, row)])
                        continue;
                    const Vec2d center{column + 0.5, row + 0.5};
                    const double share = std::clamp(dot(center - begin, side) / dot(side, side), 0.0, 1.0);
                    const Vec2d away = center - begin - side * share;
                    ring_.push_back({static_cast<std::uint32_t>(number(column, row)), dot(away, away), chart,
                                     charts_.of_face[other_face], place(center)});
                }
        }
    }

    const Mesh& mesh_;
    const Charts& charts_;
    const TexelFaces& faces_;
    const Progress& progress_;
    std::vector<std::uint32_t> chart_;
    std::vector<Continued> ring_;
};

/// Slope of the height, per texel along a row (`step` 1) or down a column (`step` S); one-sided where the other side is unknown.
double slope(const RasterF& height, const Surface& surface, std::size_t texel, std::size_t step, bool has_before, bool has_after)
{
    const auto goes_on = [&](std::size_t to) { return surface.chart(to) == surface.chart(texel); };
    const std::size_t before = has_before && goes_on(texel - step) ? texel - step : texel;
    const std::size_t after = has_after && goes_on(texel + step) ? texel + step : texel;
    const double texels = static_cast<double>(after - before) / static_cast<double>(step);
    return texels == 0 ? 0 : (double{height.values[after]} - double{height.values[before]}) / texels;
}

}  // namespace

Relief relief_of(RasterF height, const Mesh& mesh, const Charts& charts, const TexelFaces& faces, double height_m,
                 const Progress& progress)
{
    const auto size = static_cast<std::size_t>(faces.size);
    Relief relief;
    relief.atlas = atlas_id(mesh);
    relief.normals = Raster16(faces.size, faces.size, 3);
    relief.roughness = Raster8(faces.size, faces.size);
    Surface surface(mesh, charts, faces, progress);
    surface.continue_values<double>([&](std::size_t texel) { return double{height.values[texel]}; },
                                    [&](std::size_t texel, double h) { height.values[texel] = static_cast<float>(h); });
    const WeldedMesh welded = weld(mesh);
    parallel_items(height.values.size(), texels_per_block, progress,
                   [&](std::size_t texel)
                   {
                       if (surface.chart(texel) == TexelFaces::none)
                           return;
                       const double share = double{height.values[texel]} / height_m;
                       relief.roughness.values[texel] = static_cast<std::uint8_t>(
                           std::lround(255 * (canvas_roughness + share * (paint_roughness - canvas_roughness))));
                       if (!faces.inside[texel])
                           return;
                       const std::uint32_t face = faces.face[texel];
                       const auto weights = texel_weights(mesh, faces, texel);
                       Vec3d normal;
                       for (std::size_t i = 0; i < 3; ++i)
                           normal += vec_cast<double>(welded.normals[welded.indices[3 * std::size_t{face} + i]]) * weights[i];
                       normal = normalized(normal);
                       const std::size_t x = texel % size, y = texel / size;
                       const double to_right = slope(height, surface, texel, 1, x > 0, x + 1 < size);
                       const double downward = slope(height, surface, texel, size, y > 0, y + 1 < size);
                       const DualFrame frame(mesh, face, faces.size);
                       const Vec3d gradient = frame.across * to_right + frame.along * downward;
                       // Along the smooth surface, which the face only approximates.
                       const Vec3d tilted = normal - (gradient - normal * dot(gradient, normal));
                       relief.set_normal(texel, vec_cast<float>(normalized(tilted)));
                   });
    surface.continue_values<Vec3d>([&](std::size_t texel) { return vec_cast<double>(relief.normal(texel)); },
                                   [&](std::size_t texel, Vec3d n) { relief.set_normal(texel, vec_cast<float>(normalized(n))); });
    return relief;
}
