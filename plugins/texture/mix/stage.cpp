#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/page/page.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>
#include <fresco/viewer.h>

#include "mix.h"
#include "mixture.h"

#include <array>
#include <fmt/format.h>
#include <utility>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

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
        check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that the textures were made with");
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
        Mix mixed = mix(from, to, *mesh, faces, *split_cm / 100, {*color, *strokes}, run);
        run.report("from_photo", mixed.from_photo);
        run.report("from_painted", mixed.from_painted);
        Texture result;
        result.atlas = atlas_id(*mesh);
        result.layers.push_back(std::move(mixed.rgb));
        result.seen = Raster8(faces.size, faces.size);
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
            result.seen.values[texel] = faces.covered(texel) ? 1 : 0;
        run.progress(2, 3, "steps");
        Mixture small;
        small.atlas = atlas_id(*mesh);
        small.color = *color;
        small.strokes = *strokes;
        constexpr int page_px = 1024;
        const std::array full{std::move(mixed.photo), std::move(mixed.colors), std::move(mixed.painted)};
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

/// The entry `mixture` (sdk/docs/report.md).
class MixtureViewer final : public Viewer
{
  public:
    MixtureViewer() : Viewer(RegisteredArtifact<Mixture>::type) {}

  private:
    Slot<ImageIo> images{this, "Encodes pictures"};

    void show(const Artifact& artifact, PageEntry& entry) const override
    {
        constexpr int quality = 88;
        const auto& mixture = dynamic_cast<const Mixture&>(artifact);
        const auto picture = [&](const Raster8& pixels)
        { return page::data_uri("image/jpeg", images->encode_jpeg(pixels, quality)); };
        entry.value.set("mixture", Value::Map{{"atlas", mixture.atlas},
                                              {"color", mixture.color},
                                              {"strokes", mixture.strokes},
                                              {"photo", picture(mixture.photo)},
                                              {"colors", picture(mixture.colors)},
                                              {"painted", picture(mixture.painted)}});
    }
};
}  // namespace

FRESCO_STAGE("texture.mix", TextureMix, "Mixes a photographic and a painted texture, colors and strokes in shares of their own")
FRESCO_COMPONENT("view.texture_mixture", MixtureViewer, Viewer, "Shows the sliders of a mixture in the report")
