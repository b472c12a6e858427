#include <fresco/texturing/enlarge.h>

#include <fresco/stage.h>
#include <fresco/texture.h>

#include <cmath>
#include <fmt/format.h>
#include <utility>

using namespace fresco;

namespace
{

constexpr double fewest_pixels_per_texel = 0.5;

class TextureEnlarge final : public Stage
{
    Input<SourceMap> source{this, "source", "Where in the picture each texel of a painted texture comes from"};
    Input<Image> style{this, "style", "The picture that it was painted after, or a larger copy of it"};
    Input<Mesh> mesh{this, "mesh", "The mesh with the atlas that was painted"};
    Output<TexturedMesh> textured_mesh{this, "textured_mesh", "The mesh with its 8-bit picture"};
    Option<int> size_px{this, "size_px", 8192, range(16, 16384), "Texels per side"};

    Cost cost() const override
    {
        return {.seconds = {.fixed = 1, .per = {{count::texels, 2e-7}}},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 100, .per = {{count::faces, 3e-4}, {count::texels, 8.5e-6}}},
                .disk_mb = {.per = {{count::faces, 4.8e-5}, {count::texels, 3e-6}}},
                .makes = {{count::texels, {.squares_of = "size_px"}}}};
    }

    void check() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (mesh->texcoords.empty())
            throw Error("the mesh on port 'mesh' has no texcoords: wire the atlas.* stage that was painted");
        check_atlas(source->atlas, *mesh, "the source map on port 'source'");
        enlarge::check_picture(*source, style->pixels);
        check_size();
    }

    void check_size() const
    {
        if (*size_px < source->size_px())
            throw Error(fmt::format("size_px {} is less than the source map's {}: for a smaller texture use texture.bake, and "
                                    "max_texture_px where it is exported",
                                    *size_px, source->size_px()));
        const int width = style->pixels.width;
        const double pixels = enlarge::pixels_per_texel(*source, width, *size_px);
        if (pixels >= fewest_pixels_per_texel)
            return;
        const double most_px = *size_px * pixels / fewest_pixels_per_texel;
        const std::string smaller =
            most_px >= source->size_px() ? fmt::format("set size_px to {} at most, or ", static_cast<int>(most_px)) : "";
        throw Error(
            fmt::format("at size_px {} a texel would be {:.2g} pixels of the style picture, which holds no more detail: "
                        "{}wire a copy of the picture at least {:.0f} pixels wide (it has {}), or use a smaller stroke_cm",
                        *size_px, pixels, smaller, std::ceil(width * fewest_pixels_per_texel / pixels), width));
    }

    void run(RunContext& run) override
    {
        check();
        enlarge::Enlarged enlarged = enlarge::enlarged(*source, style->pixels, *mesh, *size_px, enlarge::Colors::painted, run);
        run.report("pixels_per_texel", enlarge::pixels_per_texel(*source, style->pixels.width, *size_px));
        run.report("painted_share", enlarged.painted_share);
        TexturedMesh result;
        result.image = Image(std::move(enlarged.picture));
        result.mesh = *mesh;
        result.mesh_folder = mesh.folder();
        textured_mesh = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("texture.enlarge", TextureEnlarge,
             "Copies the picture's full detail to a painted surface, up to 16384 texels a side")
