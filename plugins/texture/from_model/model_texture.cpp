#include "model_texture.h"

#include <fresco/geometry/surface_search.h>
#include <fresco/images/filters.h>
#include <fresco/parallel.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

namespace from_model
{

using fresco::Mesh;
using fresco::Vec3d;
using fresco::geometry::SurfacePoint;
using fresco::geometry::SurfaceSearch;
using fresco::texturing::FaceFrame;
using fresco::texturing::TexelFaces;

namespace
{

constexpr std::size_t rows_per_piece = 4;
constexpr int most_places = 6;

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
            frame_ = FaceFrame(atlas_, face_, faces_.size);
            normal_ = frame_.normal();
            texel_m_ = frame_.area == 0 ? 0 : std::sqrt(length(normal_) / std::abs(frame_.area));
        }
        const auto middle = fresco::vec_cast<double>(texel_position(atlas_, faces_, texel));
        const SurfacePoint nearest = search_.nearest_facing(middle, normal_, reach_m_, hint_);
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
        const double pixels = colors_.pixels_per_meter(nearest.face) * texel_m_;
        const int side = static_cast<int>(std::clamp(std::ceil(pixels - 0.25), 1.0, double{most_places}));
        if (side == 1)
            return colors_.at(nearest.face, nearest.weights);
        Vec3d sum;
        int count = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
            {
                const Vec3d place = middle + frame_.right * ((x + 0.5) / side - 0.5) + frame_.down * ((y + 0.5) / side - 0.5);
                const SurfacePoint point = search_.nearest_facing(place, normal_, reach_m_, nearest.face);
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
    FaceFrame frame_;
    Vec3d normal_;
    double texel_m_ = 0;  ///< The side of a texel of the face.
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

}  // namespace

ModelTexture transfer_colors(const fresco::Model& model, const ModelColors& colors, const Mesh& atlas, int size_px,
                             double max_distance_m, fresco::Progress& progress)
{
    const TexelFaces faces = fresco::texturing::find_texel_faces(atlas, fresco::texturing::find_charts(atlas), size_px, progress);
    const SurfaceSearch search(model.mesh);
    const auto size = static_cast<std::size_t>(size_px);
    ModelTexture texture;
    texture.picture = fresco::RasterF(size_px, size_px, 3);
    texture.seen = fresco::Raster8(size_px, size_px, 1);
    std::vector<RowFigures> figures(size);
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(size, rows_per_piece, progress,
                         [&](std::size_t begin, std::size_t end)
                         {
                             progress.check_canceled();
                             TexelPainter painter(colors, search, atlas, faces, max_distance_m);
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
    double sum = 0;
    for (const RowFigures& row : figures)
    {
        texture.chart_texels += row.chart_texels;
        texture.far_texels += row.far_texels;
        texture.largest_distance_m = std::max(texture.largest_distance_m, row.largest_m);
        sum += row.distances_m;
    }
    if (texture.chart_texels > texture.far_texels)
        texture.mean_distance_m = sum / static_cast<double>(texture.chart_texels - texture.far_texels);
    fresco::push_pull(texture.picture, texture.seen);
    return texture;
}

}  // namespace from_model
