#include "swatches.h"

#include <fresco/images/lab.h>
#include <fresco/parallel.h>
#include <fresco/random.h>
#include <fresco/texturing/charts.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

using namespace fresco;

namespace
{
constexpr std::size_t most_tries = 20 * most_swatches;
constexpr std::size_t tries_together = 500;
constexpr int most_per_sample = 8;     // Lookups along a sample's side.
constexpr int fitted = 8;              // Texels to either side of the middle, at most, that a plane is fitted to.
constexpr double unevenness = 0.05;    // Of the side.
constexpr double fitted_share = 0.75;  // Of the texels around that must be the chart's.
constexpr std::size_t rows_per_piece = 64;

Vec3f lab_at(const Raster8& rgb, std::size_t pixel)
{
    const auto value = [&](std::size_t c) { return static_cast<float>(rgb.values[3 * pixel + c]) / 255; };
    return lab_from_rgb({value(0), value(1), value(2)});
}

RasterF light_of(const Raster8& rgb, const Progress& progress)
{
    RasterF light(rgb.width, rgb.height);
    parallel_for(static_cast<std::size_t>(rgb.height), rows_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     const auto width = static_cast<std::size_t>(rgb.width);
                     for (std::size_t i = begin * width; i < end * width; ++i)
                         light.values[i] = lab_at(rgb, i).x;
                 });
    return light;
}

/// One pixel's step along a swatch's two sides, in pixels of what it is cut out of.
struct Axes
{
    Vec2d right, down;
};

/// Samples around `middle`, `steps` apart. \pre All of it lies in the picture.
RasterF cut(const RasterF& light, Vec2d middle, const Axes& steps)
{
    constexpr int count = Swatch::samples;
    const double longest = std::max(length(steps.right), length(steps.down));
    const int lookups = std::clamp(static_cast<int>(std::ceil(longest)), 1, most_per_sample);
    const auto at = [&](double x, double y)
    {
        const double px = std::clamp(x - 0.5, 0.0, light.width - 1.001);
        const double py = std::clamp(y - 0.5, 0.0, light.height - 1.001);
        const int x0 = static_cast<int>(px);
        const int y0 = static_cast<int>(py);
        const double fx = px - x0;
        const double fy = py - y0;
        const auto value = [&](int i, int j)
        { return double{light.at(std::min(i, light.width - 1), std::min(j, light.height - 1))}; };
        return (value(x0, y0) * (1 - fx) + value(x0 + 1, y0) * fx) * (1 - fy) +
               (value(x0, y0 + 1) * (1 - fx) + value(x0 + 1, y0 + 1) * fx) * fy;
    };
    RasterF result(count, count);
    for (int y = 0; y < count; ++y)
        for (int x = 0; x < count; ++x)
        {
            double sum = 0;
            for (int j = 0; j < lookups; ++j)
                for (int i = 0; i < lookups; ++i)
                {
                    const double across = x + (i + 0.5) / lookups - count / 2.0;
                    const double along = y + (j + 0.5) / lookups - count / 2.0;
                    const Vec2d p = middle + steps.right * across + steps.down * along;
                    sum += at(p.x, p.y);
                }
            result.at(x, y) = static_cast<float>(sum / (lookups * lookups));
        }
    return result;
}

/// L*a*b*, the mean of single pixels all over the square that `cut` takes.
Vec3f mean_color(const Raster8& rgb, Vec2d middle, const Axes& steps)
{
    constexpr int points = 8;  // Along a side.
    Vec3f sum;
    for (int j = 0; j < points; ++j)
        for (int i = 0; i < points; ++i)
        {
            const auto samples = [](int at) { return ((at + 0.5) / points - 0.5) * Swatch::samples; };
            const Vec2d p = middle + steps.right * samples(i) + steps.down * samples(j);
            const auto pixel = [](double at, int size) { return static_cast<std::size_t>(std::clamp(at, 0.0, size - 1.0)); };
            sum += lab_at(rgb, pixel(p.y, rgb.height) * static_cast<std::size_t>(rgb.width) + pixel(p.x, rgb.width));
        }
    return sum * (1.0F / (points * points));
}

class SurfaceCutter
{
  public:
    SurfaceCutter(const Mesh& mesh, const Raster8& picture, double side_m, const Progress& progress)
        : mesh_(mesh), picture_(picture), side_m_(side_m), charts_(texturing::find_charts(mesh)),
          faces_(texturing::find_texel_faces(mesh, charts_, picture.width, progress)), light_(light_of(picture, progress))
    {
        double area = 0;
        double uv_area = 0;
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        {
            const Triangle& t = mesh.triangles[f];
            const Vec2f* uv = &mesh.texcoords[3 * f];
            area +=
                double{length(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]))};
            uv_area += std::abs(double{cross(uv[1] - uv[0], uv[2] - uv[0])});
        }
        texel_m_ = uv_area > 0 ? std::sqrt(area / uv_area) / picture.width : 0;
        for (std::size_t texel = 0; texel < faces_.inside.size(); ++texel)
            if (faces_.inside[texel] != 0)
                texels_.push_back(static_cast<std::uint32_t>(texel));
    }

    std::vector<Swatch> cut_all(const Progress& progress) const
    {
        std::vector<Swatch> result;
        if (texels_.empty() || texel_m_ <= 0)
            return result;
        Random random(1);
        std::vector<std::uint32_t> tries(most_tries);
        for (std::uint32_t& texel : tries)
            texel = texels_[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(texels_.size())))];
        std::vector<std::optional<Swatch>> found(tries_together);
        for (std::size_t first = 0; first < tries.size() && result.size() < most_swatches; first += tries_together)
        {
            parallel_for(tries_together, 8, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             for (std::size_t i = begin; i < end; ++i)
                                 found[i] = cut_at(tries[first + i]);
                         });
            for (std::optional<Swatch>& swatch : found)
                if (swatch && result.size() < most_swatches)
                    result.push_back(std::move(*swatch));
        }
        return result;
    }

  private:
    std::uint32_t chart_at(int x, int y) const
    {
        if (x < 0 || y < 0 || x >= faces_.size || y >= faces_.size)
            return TexelFaces::none;
        const std::size_t texel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(x);
        return faces_.inside[texel] != 0 ? charts_.of_face[faces_.face[texel]] : TexelFaces::none;
    }

    /// How the surface runs around a texel: fitted to the points of its chart within reach, nothing unless they are even.
    std::optional<Axes> steps_at(int x, int y) const
    {
        const std::uint32_t chart = chart_at(x, y);
        const int radius = std::max(1, static_cast<int>(std::ceil(0.71 * side_m_ / texel_m_)));
        const int stride = std::max(1, radius / fitted);
        std::vector<Vec2d> places;
        std::vector<Vec3d> points;
        int all = 0;
        for (int j = -radius; j <= radius; j += stride)
            for (int i = -radius; i <= radius; i += stride)
            {
                if (i * i + j * j > radius * radius)
                    continue;
                ++all;
                if (chart_at(x + i, y + j) != chart)
                    continue;
                const std::size_t texel =
                    static_cast<std::size_t>(y + j) * static_cast<std::size_t>(faces_.size) + static_cast<std::size_t>(x + i);
                places.push_back({double(i), double(j)});
                points.push_back(vec_cast<double>(texturing::texel_position(mesh_, faces_, texel)));
            }
        if (static_cast<double>(places.size()) < fitted_share * all || places.size() < 3)
            return std::nullopt;
        return fitted_steps(places, points);
    }

    std::optional<Axes> fitted_steps(std::vector<Vec2d>& places, std::vector<Vec3d>& points) const
    {
        const double share = 1 / static_cast<double>(places.size());
        Vec2d place;
        Vec3d point;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            place = place + places[i] * share;
            point += points[i] * share;
        }
        double xx = 0, xy = 0, yy = 0;
        Vec3d px, py;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            places[i] = places[i] - place;
            points[i] = points[i] - point;
            xx += places[i].x * places[i].x;
            xy += places[i].x * places[i].y;
            yy += places[i].y * places[i].y;
            px += points[i] * places[i].x;
            py += points[i] * places[i].y;
        }
        const double determinant = xx * yy - xy * xy;
        if (determinant <= 0)
            return std::nullopt;
        const Vec3d along_x = (px * yy - py * xy) * (1 / determinant);
        const Vec3d along_y = (py * xx - px * xy) * (1 / determinant);
        double off = 0;
        for (std::size_t i = 0; i < places.size(); ++i)
        {
            const Vec3d rest = points[i] - along_x * places[i].x - along_y * places[i].y;
            off += dot(rest, rest) * share;
        }
        if (std::sqrt(off) > unevenness * side_m_)
            return std::nullopt;
        // The inverse of (along_x, along_y) in an orthonormal basis of their plane.
        const double stretch = length(along_x);
        if (stretch <= 0)
            return std::nullopt;
        const double shear = dot(along_x, along_y) / stretch;
        const double rest = std::sqrt(std::max(dot(along_y, along_y) - shear * shear, 0.0));
        if (rest <= 0)
            return std::nullopt;
        const double step = side_m_ / Swatch::samples;
        return Axes{Vec2d{step / stretch, 0}, Vec2d{-shear / stretch * step / rest, step / rest}};
    }

    std::optional<Swatch> cut_at(std::uint32_t texel) const
    {
        const auto size = static_cast<std::uint32_t>(faces_.size);
        const int x = static_cast<int>(texel % size);
        const int y = static_cast<int>(texel / size);
        const std::optional<Axes> steps = steps_at(x, y);
        if (!steps)
            return std::nullopt;
        const std::uint32_t chart = chart_at(x, y);
        const Vec2d middle{x + 0.5, y + 0.5};
        constexpr int half = Swatch::samples / 2;
        for (int j = -half; j <= half; ++j)
            for (int i = -half; i <= half; ++i)
            {
                const Vec2d p = middle + steps->right * i + steps->down * j;
                if (chart_at(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y))) != chart)
                    return std::nullopt;
            }
        return Swatch{cut(light_, middle, *steps),
                      mean_color(picture_, middle, *steps),
                      {static_cast<float>(middle.x / faces_.size), static_cast<float>(1 - middle.y / faces_.size)},
                      texturing::texel_position(mesh_, faces_, texel)};
    }

    using TexelFaces = texturing::TexelFaces;

    const Mesh& mesh_;
    const Raster8& picture_;
    double side_m_;
    double texel_m_ = 0;
    texturing::Charts charts_;
    TexelFaces faces_;
    RasterF light_;
    std::vector<std::uint32_t> texels_;
};
}  // namespace

std::vector<Swatch> surface_swatches(const Mesh& mesh, const Raster8& picture, double side_m, const Progress& progress)
{
    return SurfaceCutter(mesh, picture, side_m, progress).cut_all(progress);
}

std::vector<Swatch> picture_swatches(const Raster8& rgb, double side_px)
{
    std::vector<Swatch> result;
    if (rgb.width < side_px || rgb.height < side_px)
        return result;
    const RasterF light = light_of(rgb, Progress());
    const double step = side_px / Swatch::samples;
    Random random(1);
    for (std::size_t i = 0; i < most_swatches; ++i)
    {
        const double x = side_px / 2 + random.uniform() * (rgb.width - side_px);
        const double y = side_px / 2 + random.uniform() * (rgb.height - side_px);
        const Axes steps{{step, 0}, {0, step}};
        result.push_back({cut(light, {x, y}, steps), mean_color(rgb, {x, y}, steps), {}, {}});
    }
    return result;
}
