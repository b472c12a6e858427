#include <fresco/texturing/enlarge.h>
#include <fresco/texturing/texel_faces.h>

#include <fresco/stage.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

using namespace fresco;

namespace
{

constexpr double fewest_pixels_per_texel = 0.5;
constexpr int block_px = 4;              // Graphics cards compress textures by blocks of this side.
constexpr int most_px_by_itself = 8192;  // Many devices show no larger texture, and exports of one take gigabytes.

class TextureEnlarge final : public Stage
{
    Input<SourceMap> source{this, "source", "Where in the picture each texel of a painted texture comes from"};
    Input<Image> style{this, "style", "The picture that it was painted after, or a larger copy of it"};
    Input<Mesh> mesh{this, "mesh", "The mesh with the atlas that was painted"};
    Output<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its 8-bit picture"};
    Option<int> size_px{this, "size_px", 0, range(0, 16384),
                        "Texels per side, at least the source map's; 0: as large as the picture allows, up to 8192"};

    void check() const
    {
        texturing::check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that was painted");
        check_atlas(source->atlas, *mesh, "the source map on port 'source'");
        enlarge::check_picture(*source, style->pixels);
    }

    /// Returns the texels per side to paint.
    int checked_size() const
    {
        const int map_px = source->size_px();
        const int width = style->pixels.width;
        const int most_px =
            static_cast<int>(map_px * enlarge::pixels_per_texel(*source, width, map_px) / fewest_pixels_per_texel + 1e-3);
        if (*size_px == 0)
            return std::max(std::min(most_px, most_px_by_itself) / block_px * block_px, map_px);
        if (*size_px < map_px)
            throw Error(fmt::format("size_px {} is less than the source map's {}: for a smaller texture use texture.bake, and "
                                    "max_texture_px where it is exported",
                                    *size_px, map_px));
        const double pixels = enlarge::pixels_per_texel(*source, width, *size_px);
        if (*size_px > most_px)
            throw Error(
                fmt::format("at size_px {} a texel would be {:.2g} pixels of the style picture, which holds no more "
                            "detail: set size_px to 0, wire a copy of the picture at least {:.0f} pixels wide (it has {}), "
                            "or use a smaller stroke_cm",
                            *size_px, pixels, std::ceil(width * fewest_pixels_per_texel / pixels), width));
        return *size_px;
    }

    void run(RunContext& run) override
    {
        check();
        const int texels = checked_size();
        const double pixels = enlarge::pixels_per_texel(*source, style->pixels.width, texels);
        if (*size_px == 0)
            run.message(fmt::format("{} texels a side, {:.2g} pixels of the picture each", texels, pixels));
        enlarge::Enlarged enlarged = enlarge::enlarged(*source, style->pixels, *mesh, texels, enlarge::Colors::painted, run);
        run.report("size_px", texels);
        run.report("pixels_per_texel", pixels);
        run.report("painted_share", enlarged.painted_share);
        TexturedMesh result;
        result.image = Image(std::move(enlarged.picture));
        result.mesh = *mesh;
        result.mesh.saved_in = mesh.folder();
        textured_mesh = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("texture.enlarge", TextureEnlarge,
             "Copies the picture's full detail to a painted surface, up to 16384 texels a side")
