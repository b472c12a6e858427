#include "uv_charts.h"

#include <fresco/stage.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>

namespace
{

/// Depth (uv) up to which faces may reach into each other by rounding: a hundredth of a texel of a 4096 texture.
constexpr double overlap_tolerance = 0.01 / 4096;

void check_texcoords(const fresco::Mesh& mesh)
{
    if (mesh.texcoords.empty())
        throw fresco::Error(
            "the mesh on port 'mesh' has no texture coordinates: use a mesh file that has them, or make an atlas with "
            "atlas.project");
    for (std::size_t c = 0; c < mesh.texcoords.size(); ++c)
    {
        const auto uv = mesh.texcoords[c];
        if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1))
            throw fresco::Error(fmt::format("face {} has the texture coordinate ({}, {}) outside [0,1]: the texture repeats or "
                                            "has several tiles; lay it out in one tile, or make an atlas with atlas.project",
                                            c / 3, uv.x, uv.y));
    }
}

class AtlasKeep final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh with texture coordinates in [0,1]"};
    fresco::Output<fresco::Mesh> atlas{this, "atlas", "The same mesh with its own texture coordinates and their charts"};
    fresco::Option<int> size_px{this, "size_px", 2048, fresco::range(64, 16384),
                                "Texels per side of the texture: uv maps and what paints take it from the atlas"};

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "atlas.keep: input mesh");
        check_texcoords(*mesh);
        auto kept = *mesh;
        kept.charts = uv_charts(*mesh);
        kept.texture_px = *size_px;
        run.check_canceled();
        const auto measures = measure_uv(*mesh, overlap_tolerance);
        run.report("charts", static_cast<std::int64_t>(*std::max_element(kept.charts.begin(), kept.charts.end())) + 1);
        run.report("used_share", measures.used_share);
        run.report("overlap_share", measures.overlap_share);
        run.report("mirrored_share", measures.mirrored_share);
        if (measures.overlap_share > 0)
            run.warning(fmt::format("faces with {:.1f} % of the atlas's area lie on other faces: these parts of the surface will "
                                    "show the same paint; atlas.project makes an atlas without overlaps",
                                    100 * measures.overlap_share));
        atlas = std::move(kept);
    }
};

}  // namespace

FRESCO_STAGE("atlas.keep", AtlasKeep, "Keeps the mesh's own texture coordinates as its atlas")
