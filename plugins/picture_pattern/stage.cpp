#include "pattern.h"

#include <fresco/image.h>
#include <fresco/numerics/noise.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

namespace
{

class PicturePattern final : public fresco::Stage
{
    fresco::Option<std::string> kind{
        this, "kind", "strokes", fresco::one_of({"strokes", "waves", "mosaic"}),
        "strokes: a swirling sky in short strokes; waves: outlined bands in long ones; mosaic: stones"};
    fresco::Option<std::string> palette{this, "palette", "night", fresco::one_of({"night", "meadow", "ember", "sea"}), "Colors"};
    fresco::Option<int> size_px{this, "size_px", 512, fresco::range(64, 2048), "Width and height"};
    fresco::Option<double> scale{this, "scale", 1.0, fresco::range(0.4, 3),
                                 "Size of strokes and stones; 1: about a twentieth of the picture"};
    fresco::Option<int> seed{this, "seed", 1, fresco::range(0, 1'000'000'000), "Another seed gives another picture"};
    fresco::Output<fresco::Image> picture{this, "picture", "The generated picture, RGB"};

    void run(fresco::RunContext& run) override
    {
        const auto random = fresco::noise::hash(static_cast<std::uint32_t>(*seed), 3u);
        const auto colors = pattern::palette_named(*palette);
        const auto size = static_cast<float>(*scale);
        if (*kind == "waves")
            picture = fresco::Image(
                pattern::paint(pattern::RollingWaves(colors, random),
                               {.size_px = *size_px, .stroke_share = 0.034f * size, .stroke_length = 10, .seed = random}, run));
        else if (*kind == "strokes")
            picture = fresco::Image(
                pattern::paint(pattern::SwirlingSky(colors, random),
                               {.size_px = *size_px, .stroke_share = 0.045f * size, .stroke_length = 7, .seed = random}, run));
        else
            picture = fresco::Image(pattern::lay_mosaic(pattern::SwirlingSky(colors, random), *size_px,
                                                        std::max(4, static_cast<int>(44 / size)), random, run));
    }
};

}  // namespace

FRESCO_STAGE("picture.pattern", PicturePattern, "Generates a painting-like picture from a seed")
