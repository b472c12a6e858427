#include "model_colors.h"

#include <fresco/geometry/surface_search.h>
#include <fresco/image_io.h>
#include <fresco/images/filters.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;
using namespace from_model;
using geometry::SurfacePoint;
using geometry::SurfaceSearch;
using texturing::TexelFaces;

namespace
{

// Of the diagonal of the model's box, for max_distance_m: 0.
constexpr double default_reach = 0.02;
// A texel averages up to 6 x 6 places: pictures with more pixels than this per texel are made smaller first.
constexpr double most_pixels_per_texel = 4;
constexpr double least_seen_share = 0.9;
constexpr std::size_t rows_per_piece = 4;
constexpr int most_places = 6;  // Along a texel.

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
        const Vec2f uv = atlas.texcoords[3 * std::size_t{face} + i];
        p[i] = vec_cast<double>(atlas.positions[atlas.triangles[face][i]]);
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
        const auto middle = vec_cast<double>(texel_position(atlas_, faces_, texel));
        const SurfacePoint nearest = search_.nearest_facing(middle, plane_.normal, reach_m_, hint_);
        if (!nearest.found())
            return false;
        hint_ = nearest.face;
        distance_m = std::sqrt(nearest.squared_distance);
        const Vec3d light = mean_light(middle, nearest);
        rgb[0] = static_cast<float>(texturing::displayed(light.x));
        rgb[1] = static_cast<float>(texturing::displayed(light.y));
        rgb[2] = static_cast<float>(texturing::displayed(light.z));
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

struct ModelTexture
{
    RasterF picture;               ///< S x S x 3, displayed RGB.
    Raster8 seen;                  ///< 1 for texels with a color of the model.
    std::size_t chart_texels = 0;  ///< Texels with their center in a chart.
    std::size_t far_texels = 0;    ///< Of these, without a point of the model in reach.
    double mean_distance_m = 0;    ///< From the other texels to the model.
    double largest_distance_m = 0;
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

/// Moves a model's colors to an atlas of the same surface, decimated or not: each texel takes the mean color of the model at the
/// nearest points to n x n places in it, n being the width of a texel in pixels of the model's picture (at most 6). Texels
/// farther than `reach_m` from the model continue the others smoothly. The same for any number of threads. Throws Canceled.
ModelTexture transfer_colors(const Model& model, const ModelColors& colors, const Mesh& atlas, int size_px, double reach_m,
                             Progress& progress)
{
    const TexelFaces faces = texturing::find_texel_faces(atlas, texturing::find_charts(atlas), size_px, progress);
    const SurfaceSearch search(model.mesh);
    const auto size = static_cast<std::size_t>(size_px);
    ModelTexture texture;
    texture.picture = RasterF(size_px, size_px, 3);
    texture.seen = Raster8(size_px, size_px, 1);
    std::vector<RowFigures> figures(size);
    std::atomic<std::size_t> done{0};
    parallel_for(size, rows_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     TexelPainter painter(colors, search, atlas, faces, reach_m);
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
    push_pull(texture.picture, texture.seen);
    return texture;
}

class TextureFromModel final : public Stage
{
    Input<Model> model{this, "model", "The model with its materials and pictures"};
    Input<Mesh> mesh{this, "mesh", "The atlas of the same surface, decimated or not"};
    Output<Texture> texture{this, "texture", "The model's colors in the atlas, in one layer"};

    Option<int> size_px{this, "size_px", 0, range(0, 16384), "Texels per side of the texture; 0: as the atlas says"};
    Option<double> max_distance_m{
        this, "max_distance_m", 0, range(0, 1e6),
        "Texels farther than this from the model count as unseen; 0: 2% of its bounding box's diagonal"};
    Slot<ImageIo> images{this, "images", "image.opencv", "Reads the model's pictures"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per = {{count::faces, 2e-6}, {count::texels, 7e-7}}},
                .parallel_share = 0.7,
                .memory_mb = {.fixed = 30, .per = {{count::faces, 2e-4}, {count::texels, 3e-5}}},
                .disk_mb = {.per = {{count::texels, 1.3e-5}}},
                .makes = {{count::texels, {.squares_of = "size_px"}}}};
    }

    void run(RunContext& run) override
    {
        check_model(*model, "the model on port 'model'");
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: wire an atlas.* stage");
        const int size = painted_size_px(*size_px, mesh->texture_px, "the mesh on port 'mesh'", run);
        const ColorSource source = color_source(*model);
        const ModelColors colors = source == ColorSource::shape ? ModelColors(*model) : ModelColors(*model, pictures(size, run));
        ModelTexture made = transfer_colors(*model, colors, *mesh, size, reach_m(), run);
        tell(source, made, run);
        Texture result;
        result.atlas = atlas_id(*mesh);
        result.layers.push_back(std::move(made.picture));
        result.seen = std::move(made.seen);
        texture = std::move(result);
    }

    double reach_m() const
    {
        if (*max_distance_m > 0)
            return *max_distance_m;
        numerics::Bounds<double> box;
        for (const Vec3f p : model->mesh.positions)
            box.add(vec_cast<double>(p));
        return default_reach * length(box.high - box.low);
    }

    /// Decoded one after the other, and no finer than the texture can use.
    std::vector<Raster8> pictures(int size, RunContext& run) const
    {
        std::vector<Raster8> result(model->pictures.size());
        for (std::size_t i = 0; i < result.size(); ++i)
        {
            run.check_canceled();
            const double pixels_per_uv = pixels_per_texel(static_cast<int>(i), size);
            if (pixels_per_uv < 0)
                continue;
            result[i] = images->read_rgb(model->loaded_from / model->pictures[i]);
            const double pixels = pixels_per_uv * std::sqrt(double{1} * result[i].width * result[i].height);
            for (int power = 1; pixels / power > most_pixels_per_texel && power <= result[i].width; power *= 2)
                result[i] = halved(result[i]);
        }
        return result;
    }

    /// The side of a texel in the picture's uv, on average over its faces; negative for a picture that no face shows.
    double pixels_per_texel(int picture, int size) const
    {
        double area = 0;
        double uv_area = 0;
        bool is_used = false;
        for (std::uint32_t face = 0; face < model->mesh.triangles.size(); ++face)
        {
            if (model->materials[model->material_of_face[face]].picture != picture)
                continue;
            is_used = true;
            area += twice_area(model->mesh, face);
            uv_area += twice_uv_area(model->mesh, face);
        }
        if (!is_used)
            return -1;
        return area > 0 ? std::sqrt(uv_area / area) * texturing::mean_texel_m(*mesh, size) : 0;
    }

    void tell(ColorSource source, const ModelTexture& made, RunContext& run) const
    {
        if (made.far_texels == made.chart_texels)
            throw Error(
                "no part of the mesh on port 'mesh' is within " + to_json(reach_m()) +
                " m of the model: wire the atlas of the mesh that the same scan.mesh stage made, or raise max_distance_m");
        const auto total = static_cast<double>(made.chart_texels);
        const double seen_share = 1 - static_cast<double>(made.far_texels) / total;
        const std::string from = source == ColorSource::pictures ? "pictures"
                                 : source == ColorSource::colors ? "colors"
                                                                 : "shape";
        run.report("colors_from", from);
        run.report("pictures", model->pictures.size());
        run.report("chart_texels", made.chart_texels);
        run.report("seen_share", seen_share);
        run.report("max_distance_m", reach_m());
        run.report("mean_distance_m", made.mean_distance_m);
        run.report("largest_distance_m", made.largest_distance_m);
        if (source == ColorSource::shape)
            run.message("the model has no pictures and one color: shaded by its shape");
        if (seen_share < least_seen_share)
            run.warning(fmt::format("{:.0f} % of the atlas is farther than {} m from the model and takes the colors around it: "
                                    "decimate less, or raise max_distance_m",
                                    100 * (1 - seen_share), to_json(reach_m())));
    }
};

}  // namespace

FRESCO_STAGE("texture.from_model", TextureFromModel, "Transfers the colors of a model's materials and pictures to an atlas")
