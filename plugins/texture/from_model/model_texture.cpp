#include "model_texture.h"

#include <fresco/geometry/surface_search.h>
#include <fresco/images/filters.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

namespace from_model
{

using fresco::Mesh;
using fresco::Vec2d;
using fresco::Vec3d;
using fresco::geometry::SurfacePoint;
using fresco::geometry::SurfaceSearch;
using fresco::texturing::TexelFaces;

namespace
{

constexpr std::size_t rows_per_piece = 4;
constexpr int most_places = 6;

/// How a face of the atlas lies in space.
struct FacePlane
{
    Vec3d normal;
    Vec3d along_x;  ///< Meters per texel to the right and down; zero for a face without area in the atlas.
    Vec3d along_y;
    double texel_m = 0;  ///< The side of a texel.
};

FacePlane plane_of(const Mesh& atlas, std::uint32_t face, int size)
{
    std::array<Vec3d, 3> p;
    std::array<Vec2d, 3> t;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const fresco::Vec2f uv = atlas.texcoords[3 * std::size_t{face} + i];
        p[i] = fresco::vec_cast<double>(atlas.positions[atlas.triangles[face][i]]);
        t[i] = {double{uv.x} * size, (1 - double{uv.y}) * size};
    }
    const Vec3d side1 = p[1] - p[0];
    const Vec3d side2 = p[2] - p[0];
    const Vec2d t1 = t[1] - t[0];
    const Vec2d t2 = t[2] - t[0];
    FacePlane plane;
    plane.normal = cross(side1, side2);
    const double area = cross(t1, t2);
    if (area == 0)
        return plane;
    plane.along_x = (side1 * t2.y - side2 * t1.y) * (1 / area);
    plane.along_y = (side2 * t1.x - side1 * t2.x) * (1 / area);
    plane.texel_m = std::sqrt(length(plane.normal) / std::abs(area));
    return plane;
}

/// Colors the texels of one piece; pieces share nothing but what they read.
class TexelPainter
{
  public:
    TexelPainter(const ModelColors& colors, const SurfaceSearch& search, const Mesh& atlas, const TexelFaces& faces,
                 double reach_m)
        : colors_(colors), search_(search), atlas_(atlas), faces_(faces), reach_m_(reach_m)
    {
    }

    /// False if the model is out of reach. `distance_m` is that of the texel's middle.
    bool paint(std::size_t texel, float* rgb, double& distance_m)
    {
        if (faces_.face[texel] != face_)
        {
            face_ = faces_.face[texel];
            plane_ = plane_of(atlas_, face_, faces_.size);
        }
        const auto middle = fresco::vec_cast<double>(texel_position(atlas_, faces_, texel));
        const SurfacePoint nearest = search_.nearest_facing(middle, plane_.normal, reach_m_, hint_);
        if (!nearest.found())
            return false;
        hint_ = nearest.face;
        distance_m = std::sqrt(nearest.squared_distance);
        const Vec3d light = mean_light(middle, nearest);
        rgb[0] = static_cast<float>(fresco::texturing::displayed(light.x));
        rgb[1] = static_cast<float>(fresco::texturing::displayed(light.y));
        rgb[2] = static_cast<float>(fresco::texturing::displayed(light.z));
        return true;
    }

  private:
    Vec3d mean_light(Vec3d middle, const SurfacePoint& nearest) const
    {
        const double pixels = colors_.pixels_per_meter(nearest.face) * plane_.texel_m;
        const int side = static_cast<int>(std::clamp(std::ceil(pixels - 0.25), 1.0, double{most_places}));
        if (side == 1)
            return colors_.at(nearest.face, nearest.weights);
        Vec3d sum;
        int count = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
            {
                const Vec3d place =
                    middle + plane_.along_x * ((x + 0.5) / side - 0.5) + plane_.along_y * ((y + 0.5) / side - 0.5);
                const SurfacePoint point = search_.nearest_facing(place, plane_.normal, reach_m_, nearest.face);
                if (!point.found())
                    continue;
                sum += colors_.at(point.face, point.weights);
                ++count;
            }
        return count > 0 ? sum * (1.0 / count) : colors_.at(nearest.face, nearest.weights);
    }

    const ModelColors& colors_;
    const SurfaceSearch& search_;
    const Mesh& atlas_;
    const TexelFaces& faces_;
    double reach_m_;
    std::uint32_t face_ = TexelFaces::none;
    FacePlane plane_;
    std::uint32_t hint_ = SurfacePoint::none;
};

/// Figures of one row.
struct RowFigures
{
    std::size_t chart_texels = 0;
    std::size_t far_texels = 0;
    double distances_m = 0;
    double largest_m = 0;
};

void add_figures(const std::vector<RowFigures>& rows, ModelTexture& texture)
{
    double sum = 0;
    for (const RowFigures& row : rows)
    {
        texture.chart_texels += row.chart_texels;
        texture.far_texels += row.far_texels;
        texture.largest_distance_m = std::max(texture.largest_distance_m, row.largest_m);
        sum += row.distances_m;
    }
    if (texture.chart_texels > texture.far_texels)
        texture.mean_distance_m = sum / static_cast<double>(texture.chart_texels - texture.far_texels);
}

}  // namespace

ModelTexture transfer_colors(const fresco::Model& model, const ModelColors& colors, const Mesh& atlas, const TransferRules& rules,
                             fresco::Progress& progress)
{
    const TexelFaces faces =
        fresco::texturing::find_texel_faces(atlas, fresco::texturing::find_charts(atlas), rules.size_px, progress);
    const SurfaceSearch search(model.mesh);
    const auto size = static_cast<std::size_t>(rules.size_px);
    ModelTexture texture;
    texture.picture = fresco::RasterF(rules.size_px, rules.size_px, 3);
    texture.seen = fresco::Raster8(rules.size_px, rules.size_px, 1);
    std::vector<RowFigures> figures(size);
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(size, rows_per_piece, progress,
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             TexelPainter painter(colors, search, atlas, faces, rules.max_distance_m);
                             for (std::size_t texel = begin * size; texel < end * size; ++texel)
                             {
                                 if (!faces.covered(texel))
                                     continue;
                                 RowFigures& row = figures[texel / size];
                                 double distance_m = 0;
                                 const bool found = painter.paint(texel, &texture.picture.values[3 * texel], distance_m);
                                 texture.seen.values[texel] = found ? 1 : 0;
                                 if (faces.inside[texel] == 0)
                                     continue;
                                 ++row.chart_texels;
                                 row.far_texels += found ? 0 : 1;
                                 row.distances_m += distance_m;
                                 row.largest_m = std::max(row.largest_m, distance_m);
                             }
                             progress.progress(static_cast<double>(done += end - begin), static_cast<double>(size), "rows");
                         });
    add_figures(figures, texture);
    fresco::push_pull(texture.picture, texture.seen);
    return texture;
}

}  // namespace from_model
