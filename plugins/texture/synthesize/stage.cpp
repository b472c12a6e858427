#include "line_field.h"
#include "painted_surface.h"
#include "synthesis.h"

#include <fresco/frames.h>
#include <fresco/geometry/upright.h>
#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::synthesize;

namespace
{

class TextureSynthesize final : public Stage
{
    static constexpr double curved_strokes = 4;  // A radius of so many strokes' width is curved clearly.
    static constexpr double smooth_strokes = 2;  // Directions are smoothed over so many.
    static constexpr SynthesisOptions usual{};

    Input<Mesh> mesh{this, "mesh", "The mesh with its atlas"};
    Input<Texture> start{this, "start", "The texture to paint over, in the same atlas: usually a photographic one"};
    Input<Image> style{this, "style", "The picture whose brush strokes are copied"};
    Input<Texture> lines{this, "lines", optional,
                         "A texture with lines drawn along which strokes run, in the same atlas, of any size"};
    Input<Frames> frames{this, "frames", optional, "Frames whose cameras show which way is up"};
    Output<Texture> texture{this, "texture", "The painted texture"};
    Output<SourceMap> source{this, "source", "Where in the picture each texel comes from"};

    Option<int> size_px{this, "size_px", 0, range(0, 16384), "Texels per side of the texture; 0: as the atlas says"};
    Option<double> stroke_cm{
        this, "stroke_cm", 0, range(0, 1000),
        "Width of the picture's brush strokes on the surface, whatever the texture size: half the wavelength "
        "of soft stripes; at least two texels, at most the length of the room. 0: 3.5 for a room of 3 m and more, in proportion "
        "for "
        "something smaller"};
    Option<double> painterly{this, "painterly", usual.painterly, range(0, 1),
                             "0: keep what the start shows; 1: let the picture's own motifs take over"};
    Option<double> detail{
        this, "detail", usual.detail, range(0, 1),
        "How much of the start's detail is painted over with finer strokes; 0: none, all strokes have one width"};
    Option<std::string> direction{
        this, "direction", "none", one_of({"none", "gravity", "curvature", "drawn"}),
        "Turns strokes to run down walls and slopes (gravity), along edges and pipes (curvature) or along "
        "the lines on port 'lines' (drawn); none: as they lie in the picture"};
    Option<bool> recolor{this, "recolor", true, "First recolor the start with the picture's colors; false: it already has them"};
    Option<std::string> up = geometry::up_option(this);
    Option<int> levels_count{this, "levels_count", usual.levels_count, range(1, 4),
                             "Scales to paint at, each half as fine as the next"};
    Option<int> rounds_count{this, "rounds_count", usual.rounds_count, range(1, 100),
                             "Rounds of search and vote at the coarsest scale; each finer one takes two"};
    Option<int> seed{this, "seed", 0, range(0, 2147483647), "Another seed gives another painting"};
    Slot<ImageIo> images{this, optional, "Writes previews; none: no previews"};

    /// A texture of 4096 texels a side.
    double memory_mb() const override { return 2000; }

    /// Returns the texels per side to paint.
    int check(RunContext& run) const
    {
        texturing::check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that the start was made with");
        check_atlas(start->atlas, *mesh, "the texture on port 'start'");
        if (lines.has_value() != (*direction == "drawn"))
            throw Error(lines.has_value()
                            ? fmt::format("option \"direction\" is \"{}\", so that the lines on port 'lines' are not used: "
                                          "set it to \"drawn\", or leave the port unwired",
                                          *direction)
                            : std::string("option \"direction\" is \"drawn\": wire port 'lines' to a texture with lines"));
        if (lines.has_value())
            check_atlas(lines->atlas, *mesh, "the texture on port 'lines'");
        if (style->pixels.channels != 3 && style->pixels.channels != 4)
            throw Error(fmt::format("the style picture has {} channels; expected RGB or RGBA", style->pixels.channels));
        return painted_size_px(*size_px, mesh->texture_px, "the mesh on port 'mesh'", run);
    }

    /// Per face; none where strokes are not turned.
    std::vector<Vec3f> stroke_lines(const PaintedSurface& surface, const Upright& upright, double stroke_m,
                                    const Progress& progress) const
    {
        if (*direction == "none")
            return {};
        const LineHints hints(surface, upright);
        return hints.smoothed(*direction == "gravity"     ? hints.gravity()
                              : *direction == "curvature" ? hints.curvature(curved_strokes * stroke_m)
                                                          : hints.drawn(*lines, progress),
                              smooth_strokes * stroke_m, progress);
    }

    void run(RunContext& run) override
    {
        const int texels = check(run);
        const double stroke_m = stroke_width_m(*mesh, *stroke_cm / 100, texel_width_m(*mesh, texels));
        if (*stroke_cm == 0)
            run.message(fmt::format("strokes are {:.2g} cm wide, by the size of the surface", 100 * stroke_m));
        const PaintedSurface surface(*mesh, run);
        const Vec3d upward = geometry::shown_up(*up, *mesh, frames, run);
        const Upright upright = synthesize::upright(surface, vec_cast<float>(upward));
        StartPicture picture(surface, *start, run);
        // Transparent pixels are not copied.
        texturing::OpaquePicture opaque;
        if (style->pixels.channels == 4)
            opaque = texturing::opaque_picture(style->pixels, "port 'style'", run);
        const Raster8& copied = opaque.rgb.empty() ? style->pixels : opaque.rgb;
        if (*recolor)
            picture.recolor(copied, opaque.opaque);
        run.report("up", Value::List{double{upright.up.x}, double{upright.up.y}, double{upright.up.z}});
        run.report("unseen_share", 1 - static_cast<double>(picture.known_texels()) / static_cast<double>(picture.chart_texels()));
        const std::vector<Vec3f> directions = stroke_lines(surface, upright, stroke_m, run);
        const Task task{
            surface,         upright,
            copied,          [&](std::uint32_t chart, Vec2f uv, double footprint) { return picture.at(chart, uv, footprint); },
            directions,      std::move(opaque.opaque),
            &picture.faces()};
        Painting painting = fresco::synthesize::synthesize(task,
                                                           {.size_px = texels,
                                                            .stroke_m = stroke_m,
                                                            .painterly = *painterly,
                                                            .detail = *detail,
                                                            .levels_count = *levels_count,
                                                            .rounds_count = *rounds_count,
                                                            .seed = static_cast<std::uint32_t>(*seed)},
                                                           images.has_value() ? images.get().get() : nullptr, run);
        // The colors are copied from a picture of 8 bits and baked into another. Finer steps would only fill the store.
        std::vector<float>& values = painting.texture.layers.front().values;
        std::ranges::transform(texturing::to_bytes(painting.texture.layers.front(), run).values, values.begin(),
                               [](std::uint8_t value) { return static_cast<float>(value) / 255; });
        texture = std::move(painting.texture);
        source = std::move(painting.source);
    }
};

}  // namespace

FRESCO_STAGE("texture.synthesize", TextureSynthesize, "Paints a surface with the brush strokes of a picture, without a network")
