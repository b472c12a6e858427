#include "mix.h"
#include "surface_average.h"

#include <fresco/parallel.h>
#include <fresco/texturing/charts.h>

#include <algorithm>
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

    Vec3f mean_at(std::size_t texel, const SurfaceAverage& average) const
    {
        const auto at = place(texel);
        return average.at(at.point, at.normal, difference(texel));
    }

  private:
    struct Place
    {
        Vec3f point, normal;
    };

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
    const auto size = static_cast<std::size_t>(faces.size);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t texel = begin * size; texel < end * size; ++texel)
                         if (faces.covered(texel))
                         {
                             const Vec3f mean = difference.mean_at(texel, average);
                             result.values[3 * texel] += mean.x;
                             result.values[3 * texel + 1] += mean.y;
                             result.values[3 * texel + 2] += mean.z;
                         }
                 });
    return result;
}

RasterF mix(const RasterF& photo, const RasterF& colors, const RasterF& painted, double color, double strokes)
{
    if (color == 0 && strokes == 0)
        return photo;
    if (color == 1 && strokes == 1)
        return painted;
    const auto c = static_cast<float>(color);
    const auto s = static_cast<float>(strokes);
    RasterF result = photo;
    for (std::size_t i = 0; i < result.values.size(); ++i)
        result.values[i] = std::clamp(
            photo.values[i] + c * (colors.values[i] - photo.values[i]) + s * (painted.values[i] - colors.values[i]), 0.0F, 1.0F);
    return result;
}
