#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/charts.h>
#include <fresco/texturing/collapse.h>
#include <fresco/texturing/gutter.h>
#include <fresco/texturing/smaller_picture.h>
#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texel_faces.h>

#include "mix.h"
#include "mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// Mean difference of the channels over the charts' own texels, in steps of 1/255.
double distance(const RasterF& a, const RasterF& b, const TexelFaces& faces, const Progress& progress)
{
    const auto size = static_cast<std::size_t>(faces.size);
    std::vector<double> row_sums(size);
    constexpr std::size_t rows_per_block = 16;
    parallel_for(size, rows_per_block, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t texel = begin * size; texel < end * size; ++texel)
                         if (faces.inside[texel])
                             for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
                                 row_sums[texel / size] += std::abs(double{a.values[i]} - double{b.values[i]});
                 });
    const auto texels = std::count(faces.inside.begin(), faces.inside.end(), std::uint8_t{1});
    return texels == 0 ? 0 : 255 * std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / (3.0 * static_cast<double>(texels));
}

class TextureMix final : public Stage
{
    Input<Texture> photo{this, "photo", "The photographic texture"};
    Input<Texture> painted{this, "painted", "The painted texture, of the same atlas and size"};
    Input<Mesh> mesh{this, "mesh", "The mesh whose texcoords both textures were made for"};
    Output<Texture> texture{this, "texture", "The mixture"};
    Output<Mixture> sliders{this, "sliders", "Small copies, with which report.html mixes live"};
    Option<double> color{this, "color", 1, range(0, 1), "Share of the painting's colors: 0 keeps those of the photo"};
    Option<double> strokes{this, "strokes", 1, range(0, 1),
                           "Share of the painting's strokes and detail: 0 keeps the photo's detail"};
    Option<double> split_cm{this, "split_cm", 20, range(0.5, 1000),
                            "What varies over more than this on the surface is color, the rest strokes"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per_face = 5e-7, .per_texel = 2e-7},
                .parallel_share = 0.6,
                .memory_mb = {.fixed = 50, .per_face = 1.5e-4, .per_texel = 6e-5},
                .disk_mb = {.per_texel = 1.3e-5}};
    }

    RasterF filled(const Texture& source, const Charts& charts, const TexelFaces& faces, RunContext& run) const
    {
        RasterF rgb = collapse(source, run);
        fill_unseen(*mesh, charts, faces, source.seen.values, rgb, run);
        return rgb;
    }

    void check_input(const Texture& input, const std::string& port) const
    {
        check_texture(input);
        check_atlas(input.atlas, *mesh, "the texture on port '" + port + "'");
    }

    void run(RunContext& run) override
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: wire the atlas.* stage that the textures were made with");
        check_input(*photo, "photo");
        check_input(*painted, "painted");
        if (photo->size_px() != painted->size_px())
            throw Error(fmt::format("the texture on port 'photo' has {} texels a side, the one on port 'painted' {}; make both "
                                    "with the same size_px",
                                    photo->size_px(), painted->size_px()));

        const Charts charts = find_charts(*mesh);
        const TexelFaces faces = find_texel_faces(*mesh, charts, photo->size_px(), run);
        const RasterF from = filled(*photo, charts, faces, run);
        const RasterF to = filled(*painted, charts, faces, run);
        run.progress(1, 3, "steps");
        Texture result;
        result.atlas = atlas_id(*mesh);
        const RasterF colors = recolored(from, to, *mesh, faces, *split_cm / 100, run);
        result.layers.push_back(mix(from, colors, to, *color, *strokes, run));
        result.seen = Raster8(faces.size, faces.size);
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
            result.seen.values[texel] = faces.covered(texel) ? 1 : 0;
        run.report("from_photo", distance(result.layers.front(), from, faces, run));
        run.report("from_painted", distance(result.layers.front(), to, faces, run));
        run.progress(2, 3, "steps");
        Mixture small;
        small.atlas = atlas_id(*mesh);
        small.color = *color;
        small.strokes = *strokes;
        constexpr int page_px = 1024;
        const std::array full{to_bytes(from, run), to_bytes(colors, run), to_bytes(to, run)};
        auto pictures = smaller_pictures(*mesh, charts, faces, full, page_px, run);
        if (faces.size <= page_px)  // Smaller ones have their gutters filled already.
            for (Raster8& picture : pictures)
                fill_from_nearest(picture, result.seen.values, run);
        small.photo = std::move(pictures[0]);
        small.colors = std::move(pictures[1]);
        small.painted = std::move(pictures[2]);
        texture = std::move(result);
        sliders = std::move(small);
        run.progress(3, 3, "steps");
    }
};

}  // namespace

FRESCO_STAGE("texture.mix", TextureMix, "Mixes a photographic and a painted texture, colors and strokes in shares of their own")
