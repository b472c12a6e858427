#include "mix.h"
#include "surface_average.h"

#include <fresco/parallel.h>
#include <fresco/texturing/charts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// V normals that vertices at the same position share, so that they are smooth across seams.
std::vector<Vec3f> smooth_normals(const Mesh& mesh)
{
    const auto welded = welded_vertices(mesh);
    Mesh joined;
    joined.positions = mesh.positions;
    joined.triangles = mesh.triangles;
    for (Triangle& triangle : joined.triangles)
        for (std::uint32_t& corner : triangle)
            corner = welded[corner];
    std::vector<Vec3f> normals = vertex_normals(joined);
    for (std::size_t v = 0; v < normals.size(); ++v)
        normals[v] = normals[welded[v]];
    return normals;
}

/// The weights of a face's corners at texel centers along a row, as texel_weights gives them: they change by equal steps.
class FaceRow
{
  public:
    FaceRow(const Mesh& mesh, const TexelFaces& faces, std::size_t first)
    {
        const auto size = static_cast<std::size_t>(faces.size);
        const Vec2d center{static_cast<double>(first % size) + 0.5, static_cast<double>(first / size) + 0.5};
        std::array<Vec2d, 3> to;
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2f uv = mesh.texcoords[3 * std::size_t{faces.face[first]} + i];
            to[i] = Vec2d{double{uv.x} * faces.size, (1 - double{uv.y}) * faces.size} - center;
        }
        const double area = cross(to[1] - to[0], to[2] - to[0]);
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec2d a = to[(i + 1) % 3];
            const Vec2d b = to[(i + 2) % 3];
            first_[i] = area == 0 ? 1.0 / 3 : cross(a, b) / area;
            step_[i] = area == 0 ? 0 : (a.y - b.y) / area;
        }
    }

    /// The centers of this many texels are inside the face.
    bool holds(std::size_t count) const
    {
        const double last = static_cast<double>(count - 1);
        for (std::size_t i = 0; i < 3; ++i)
            if (std::min(first_[i], first_[i] + last * step_[i]) < 0)
                return false;
        return true;
    }

    std::array<double, 3> at(std::size_t texels_on) const
    {
        std::array<double, 3> weights;
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i)
            sum += weights[i] = std::max(first_[i] + static_cast<double>(texels_on) * step_[i], 0.0);
        for (double& w : weights)
            w /= sum;
        return weights;
    }

    /// As long as the face holds the centers, what its corners have changes by this from one texel to the next.
    const std::array<double, 3>& step() const { return step_; }

  private:
    std::array<double, 3> first_;
    std::array<double, 3> step_;
};

class Difference
{
  public:
    Difference(const RasterF& photo, const RasterF& painted, const Mesh& mesh, const TexelFaces& faces)
        : photo_(photo), painted_(painted), mesh_(mesh), faces_(faces), normals_(smooth_normals(mesh))
    {
    }

    SurfaceAverage averaged(double split_m, const Progress& progress) const
    {
        const auto [low, high] = bounds();
        SurfaceAverage average(low, high, split_m);
        // Many samples in each cell are enough; all of a large texture's would only take longer.
        constexpr double samples_per_spacing = 8;
        const auto stride =
            static_cast<std::size_t>(std::clamp(average.spacing_m() / texel_m() / samples_per_spacing, 1.0, 16.0));
        const auto size = static_cast<std::size_t>(faces_.size);
        for (std::size_t y = 0; y < size; y += stride)
        {
            progress.check_canceled();
            for (std::size_t texel = y * size; texel < (y + 1) * size; texel += stride)
                if (faces_.inside[texel])
                {
                    const auto at = place(texel);
                    average.add(at.point, at.normal, difference(texel));
                }
        }
        return average;
    }

    /// Adds the mean to the texels of one row of `result`.
    void add_mean(std::size_t row, SurfaceAverage::Lookup& mean, RasterF& result) const
    {
        const auto size = static_cast<std::size_t>(faces_.size);
        const std::size_t end = (row + 1) * size;
        for (std::size_t texel = row * size; texel < end;)
        {
            const std::size_t first = texel;
            const std::uint32_t face = faces_.face[first];
            while (texel < end && faces_.face[texel] == face)
                ++texel;
            if (face != TexelFaces::none)
                add_mean(first, texel, mean, result);
        }
    }

  private:
    struct Place
    {
        Vec3f point, normal;
    };

    /// Of the texels first … end - 1, all of one row and one face.
    void add_mean(std::size_t first, std::size_t end, SurfaceAverage::Lookup& mean, RasterF& result) const
    {
        const FaceRow row(mesh_, faces_, first);
        const Triangle& corners = mesh_.triangles[faces_.face[first]];
        const auto weighted = [&](const std::array<double, 3>& weights)
        {
            Place sum;
            for (std::size_t i = 0; i < 3; ++i)
            {
                sum.point += mesh_.positions[corners[i]] * static_cast<float>(weights[i]);
                sum.normal += normals_[corners[i]] * static_cast<float>(weights[i]);
            }
            return sum;
        };
        const auto add = [&](std::size_t texel, const Place& at)
        {
            const Vec3f color = mean.at(at.point, at.normal, difference(texel));
            result.values[3 * texel] += color.x;
            result.values[3 * texel + 1] += color.y;
            result.values[3 * texel + 2] += color.z;
        };
        if (!row.holds(end - first))
        {
            for (std::size_t texel = first; texel < end; ++texel)
                add(texel, weighted(row.at(texel - first)));
            return;
        }
        const Place begin = weighted(row.at(0));
        const Place step = weighted(row.step());
        for (std::size_t texel = first; texel < end; ++texel)
        {
            const auto on = static_cast<float>(texel - first);
            add(texel, {begin.point + step.point * on, begin.normal + step.normal * on});
        }
    }

    static Vec3f value(const RasterF& raster, std::size_t texel)
    {
        return {raster.values[3 * texel], raster.values[3 * texel + 1], raster.values[3 * texel + 2]};
    }
    Vec3f difference(std::size_t texel) const { return value(painted_, texel) - value(photo_, texel); }

    Place place(std::size_t texel) const
    {
        const auto weights = texel_weights(mesh_, faces_, texel);
        const Triangle& corners = mesh_.triangles[faces_.face[texel]];
        Vec3d point;
        Vec3d normal;
        for (std::size_t i = 0; i < 3; ++i)
        {
            point += vec_cast<double>(mesh_.positions[corners[i]]) * weights[i];
            normal += vec_cast<double>(normals_[corners[i]]) * weights[i];
        }
        return {vec_cast<float>(point), vec_cast<float>(normalized(normal))};
    }

    std::pair<Vec3f, Vec3f> bounds() const
    {
        Vec3f low = mesh_.positions.front();
        Vec3f high = low;
        for (const Vec3f& p : mesh_.positions)
        {
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
        return {low, high};
    }

    /// Side of a texel on the surface, in the mean.
    double texel_m() const
    {
        double area = 0;
        for (const Triangle& t : mesh_.triangles)
            area += length(vec_cast<double>(
                        cross(mesh_.positions[t[1]] - mesh_.positions[t[0]], mesh_.positions[t[2]] - mesh_.positions[t[0]]))) /
                    2;
        const auto texels = std::count(faces_.inside.begin(), faces_.inside.end(), std::uint8_t{1});
        return std::sqrt(area / static_cast<double>(std::max<std::ptrdiff_t>(texels, 1)));
    }

    const RasterF& photo_;
    const RasterF& painted_;
    const Mesh& mesh_;
    const TexelFaces& faces_;
    std::vector<Vec3f> normals_;
};

}  // namespace

RasterF recolored(const RasterF& photo, const RasterF& painted, const Mesh& mesh, const TexelFaces& faces, double split_m,
                  const Progress& progress)
{
    const Difference difference(photo, painted, mesh, faces);
    const SurfaceAverage average = difference.averaged(split_m, progress);
    RasterF result = photo;
    constexpr std::size_t rows_per_block = 16;
    parallel_for(static_cast<std::size_t>(faces.size), rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     SurfaceAverage::Lookup mean(average);
                     for (std::size_t row = begin; row < end; ++row)
                         difference.add_mean(row, mean, result);
                 });
    return result;
}

RasterF mix(const RasterF& photo, const RasterF& colors, const RasterF& painted, double color, double strokes,
            const Progress& progress)
{
    if (color == 0 && strokes == 0)
        return photo;
    if (color == 1 && strokes == 1)
        return painted;
    const auto c = static_cast<float>(color);
    const auto s = static_cast<float>(strokes);
    RasterF result = photo;
    constexpr std::size_t values_per_block = std::size_t{1} << 18U;
    parallel_for(result.values.size(), values_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         const float tone = colors.values[i];
                         result.values[i] = std::clamp(
                             result.values[i] + c * (tone - result.values[i]) + s * (painted.values[i] - tone), 0.0F, 1.0F);
                     }
                 });
    return result;
}
