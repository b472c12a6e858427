#include "face_blocks.h"

#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <fmt/format.h>
#include <numeric>
#include <string>

namespace
{

namespace blocks = fresco::face_blocks;

class AtlasFaceBlocks final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh; existing texture coordinates are replaced"};
    fresco::Output<fresco::Mesh> atlas{this, "atlas", "The same mesh with texture coordinates, every face a chart of its own"};
    fresco::Option<int> size_px{this, "size_px", 4096, fresco::range(64, 16384),
                                "Texels per side of the texture: uv maps and what paints take it from the atlas"};
    fresco::Option<int> block_px{this, "block_px", 4, fresco::range(2, 64), "Texels per side of a face's block"};

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "atlas.face_blocks: input mesh");
        const blocks::Layout layout{.size_px = *size_px, .block_px = *block_px};
        const auto faces = mesh->triangles.size();
        if (faces > layout.blocks_count())
            throw fresco::Error(fmt::format("{} faces, but a texture of {} texels has room for {} blocks of {}: set size_px to "
                                            "{}, decimate the mesh further, or set a smaller block_px",
                                            faces, *size_px, layout.blocks_count(), *block_px,
                                            blocks::smallest_size_px(faces, *block_px)));
        fresco::Mesh result = *mesh;
        result.texcoords = blocks::texcoords(faces, layout);
        result.charts.resize(faces);
        std::iota(result.charts.begin(), result.charts.end(), 0U);
        result.texture_px = *size_px;
        run.report("faces", static_cast<std::int64_t>(faces));
        run.report("used_share", static_cast<double>(faces) / static_cast<double>(layout.blocks_count()));
        atlas = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("atlas.face_blocks", AtlasFaceBlocks, "Atlas of equal blocks of texels, one per face")
