#include <fresco/image_io.h>
#include <fresco/page/page.h>
#include <fresco/relief.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/enlarge.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/relief_maps.h>
#include <fresco/viewer.h>

#include "relief.h"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <utility>

using namespace fresco;

namespace
{

class TextureRelief final : public Stage
{
    Input<TexturedMesh> textured_mesh{this, "textured_mesh", "The painted mesh, as texture.bake or texture.enlarge makes it"};
    Input<SourceMap> source{this, "source", optional,
                            "Where in the picture each texel comes from: detail is then the picture's own, not what the painting "
                            "blended; needs 'style'"};
    Input<Image> style{this, "style", optional, "The picture that it was painted after, or a larger copy of it"};
    Output<Relief> relief{this, "relief", "Normals and roughness of the paint"};
    Option<double> height_mm{this, "height_mm", 3, range(0.01, 100), "Thickness of the thickest paint, on the surface"};
    Option<double> stroke_cm{this, "stroke_cm", 3.5, range(0.1, 1000),
                             "Width of brush strokes on the surface, as at texture.synthesize: what is wider is no relief"};

    void run(RunContext& run) override
    {
        texturing::check_textured_mesh(*textured_mesh, "the mesh on port 'textured_mesh'");
        if (source.has_value() != style.has_value())
            throw Error(source.has_value() ? "port 'source' needs port 'style': wire the picture that the room was painted from"
                                           : "port 'style' is used only with port 'source': wire texture.synthesize's 'source'");
        const Mesh& mesh = textured_mesh->mesh;
        Raster8 copied;
        if (source.has_value())
        {
            check_atlas(source->atlas, mesh, "the source map on port 'source'");
            enlarge::check_picture(*source, style->pixels);
            if (textured_mesh->image.pixels.width < source->size_px())
                throw Error(fmt::format("the mesh's picture has {} texels a side, the source map on port 'source' {}: wire the "
                                        "picture at its full size",
                                        textured_mesh->image.pixels.width, source->size_px()));
            // A copy's shift is no paint: it would raise or lower it as a whole.
            copied = enlarge::enlarged(*source, style->pixels, mesh, textured_mesh->image.pixels.width,
                                       enlarge::Colors::of_picture, run)
                         .picture;
        }
        const Raster8& rgb = source.has_value() ? copied : textured_mesh->image.pixels;
        const texturing::Charts charts = texturing::find_charts(mesh);
        const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, charts, rgb.width, run);
        const double height_m = *height_mm / 1000;
        RasterF height = paint_height(rgb, mesh, faces, height_m, *stroke_cm / 100, run);
        RasterF shown;
        if (source.has_value())
        {
            shown = strokes_shown(textured_mesh->image.pixels, rgb, *source, mesh, faces, *stroke_cm / 100, run);
            tell(shown, faces, run);
            for (std::size_t texel = 0; texel < height.values.size(); ++texel)
            {
                const auto mean = static_cast<float>(height_m / 2);
                if (faces.covered(texel))
                    height.values[texel] = mean + shown.values[texel] * (height.values[texel] - mean);
            }
        }
        Relief made = relief_of(std::move(height), mesh, charts, faces, height_m, run);
        if (source.has_value())
            keep_shown(made, shown);
        relief = std::move(made);
    }

    static void tell(const RasterF& shown, const texturing::TexelFaces& faces, RunContext& run)
    {
        constexpr double hardly_any = 0.01;
        constexpr double nearly_all = 0.95;
        double sum = 0;
        double texels = 0;
        for (std::size_t texel = 0; texel < shown.values.size(); ++texel)
            if (faces.inside[texel])
            {
                sum += double{shown.values[texel]};
                ++texels;
            }
        const double share = sum / std::max(texels, 1.0);
        run.report("shown_share", share);
        if (share < hardly_any)
            run.warning(
                "hardly any of the surface shows strokes of the picture on port 'style', so the relief is nearly flat: the "
                "painting is mixed too weakly (below about a third), or 'source' and 'style' belong to another painting");
        else if (share < nearly_all)
            run.message(fmt::format(
                "the relief is {:.0f} % of full strength on average: the rest shows the photo or another painting", 100 * share));
    }
};

/// The entry `relief` (sdk/docs/report.md).
class ReliefViewer final : public Viewer
{
  public:
    ReliefViewer() : Viewer(RegisteredArtifact<Relief>::type) {}

  private:
    Slot<ImageIo> images{this, "Encodes pictures"};

    void show(const Artifact& artifact, PageEntry& entry) const override
    {
        constexpr int most_px = 2048;
        constexpr int quality = 88;
        const auto& relief = dynamic_cast<const Relief&>(artifact);
        const texturing::ReliefMaps maps = texturing::world_maps(relief, most_px, Progress());
        entry.value.set("relief", page::relief(relief.atlas, images->encode_jpeg(maps.normals, quality),
                                               images->encode_jpeg(maps.roughness, quality)));
    }
};

}  // namespace

FRESCO_STAGE("texture.relief", TextureRelief, "Gives paint a thickness that catches the light: normals and roughness")
FRESCO_COMPONENT("view.relief", ReliefViewer, Viewer, "Lets the light in the report's room be moved")
