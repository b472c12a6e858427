#include "model_texture.h"

#include <fresco/geometry/topology.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/recordings/recorded_view.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/face_frame.h>
#include <fresco/texturing/texel_faces.h>

#include <cmath>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;
using namespace from_model;

namespace
{

// Reach as a share of the diagonal of the model's box, for max_distance_m: 0.
constexpr double default_reach = 0.02;
// A texel averages up to 6 x 6 places: pictures with more pixels than this per texel are made smaller first.
constexpr double most_pixels_per_texel = 4;
constexpr double least_seen_share = 0.9;

class TextureFromModel final : public Stage
{
    Input<Model> model{this, "model", "The model with its materials and pictures"};
    Input<Mesh> mesh{this, "mesh", "The atlas of the same surface, decimated or not"};
    Output<Texture> texture{this, "texture", "The model's colors in the atlas, in one layer"};

    Option<int> size_px{this, "size_px", 0, range(0, 16384), "Texels per side of the texture; 0: as the atlas says"};
    Slot<ImageIo> images{this, "Reads the model's pictures"};

    void run(RunContext& run) override
    {
        check_model(*model, "the model on port 'model'");
        texturing::check_has_atlas(*mesh, "the mesh on port 'mesh'", "an atlas.* stage");
        if (model->mesh.offset_m != mesh->offset_m)
            throw Error(
                "the model and the mesh are stored less different offsets (offset_m): wire the frames of the recording to port "
                "'frames' of the scan.mesh stage");
        texturing::check_layout(*mesh, "the mesh on port 'mesh'", run);
        const int size = painted_size_px(*size_px, mesh->texture_px, "the mesh on port 'mesh'", run);
        const ColorSource source = color_source(*model);
        const ModelColors colors = source == ColorSource::shape ? ModelColors(*model) : ModelColors(*model, pictures(size, run));
        const double max_distance_m = reach_m();
        ModelTexture made = transfer_colors(*model, colors, *mesh, size, max_distance_m, run);
        tell(source, made, max_distance_m, run);
        Texture result;
        result.atlas = atlas_id(*mesh);
        result.layers.push_back(std::move(made.picture));
        result.seen = std::move(made.seen);
        texture = std::move(result);
    }

    double reach_m() const
    {
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
            result[i] = picture(i);
            const double pixels = pixels_per_uv * std::sqrt(double{1} * result[i].width * result[i].height);
            for (int power = 1; pixels / power > most_pixels_per_texel && power <= result[i].width; power *= 2)
                result[i] = halved(result[i]);
        }
        return result;
    }

    /// As glTF has it for opaque materials, the color of a pixel counts whatever its alpha is.
    Raster8 picture(std::size_t number) const
    {
        const std::string name = fmt::format("picture {} of the model on port 'model'", number);
        Raster8 picture;
        const std::filesystem::path file = model->loaded_from / model->pictures[number];
        try
        {
            picture = images->read_with_alpha(file);
        }
        catch (const Error& error)
        {
            throw Error(recordings::renamed(error.what(), file, name));
        }
        if (picture.channels != 4)
            return picture;
        Raster8 rgb(picture.width, picture.height, 3);
        for (std::size_t i = 0; i < rgb.values.size(); ++i)
            rgb.values[i] = picture.values[i / 3 * 4 + i % 3];
        return rgb;
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
            area += length(geometry::area_vector(model->mesh, face));
            uv_area += std::abs(texturing::FaceFrame(model->mesh, face, 1).area);
        }
        if (!is_used)
            return -1;
        return area > 0 ? std::sqrt(uv_area / area) * texturing::mean_texel_m(*mesh, size) : 0;
    }

    void tell(ColorSource source, const ModelTexture& made, double max_distance_m, RunContext& run) const
    {
        if (made.far_texels == made.chart_texels)
            throw Error("no part of the mesh on port 'mesh' is within " + to_json(max_distance_m) +
                        " m of the model: wire the atlas of the mesh that the same scan.mesh stage made");
        const auto total = static_cast<double>(made.chart_texels);
        const double seen_share = 1 - static_cast<double>(made.far_texels) / total;
        const std::string from = source == ColorSource::pictures ? "pictures"
                                 : source == ColorSource::colors ? "colors"
                                                                 : "shape";
        run.report("colors_from", from);
        run.report("pictures", model->pictures.size());
        run.report("chart_texels", made.chart_texels);
        run.report("seen_share", seen_share);
        run.report("max_distance_m", max_distance_m);
        run.report("mean_distance_m", made.mean_distance_m);
        run.report("largest_distance_m", made.largest_distance_m);
        if (source == ColorSource::shape)
            run.message("the model has no pictures and one color: shaded by its shape");
        if (seen_share < least_seen_share)
            run.warning(
                fmt::format("{:.0f} % of the atlas is farther than {:.2g} m from the model and takes the colors around it: "
                            "decimate less",
                            100 * (1 - seen_share), max_distance_m));
    }
};

}  // namespace

FRESCO_STAGE("texture.from_model", TextureFromModel, "Transfers the colors of a model's materials and pictures to an atlas")
