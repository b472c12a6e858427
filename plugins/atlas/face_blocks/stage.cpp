#include <fresco/mesh.h>
#include <fresco/stage.h>
#include <fresco/texture.h>

#include <fmt/format.h>
#include <numeric>
#include <string>

namespace
{

using fresco::Vec2f;

/// How far the corners lie inside the centers of their texels, in texels: no rounding of a uv down to half of this makes a lookup
/// touch the block beside.
constexpr double inset_px = 1.0 / 16;

/// Square blocks of texels in a square texture, row by row from the lower left.
std::size_t blocks_per_row(int size_px, int block_px)
{
    return static_cast<std::size_t>(size_px / block_px);
}

/// Three uv per face, counter-clockwise: the first corner at the lower left texel's center of the face's own block, the second at
/// the lower right one's, the third at the upper left one's, each inset_px inside. A bilinear lookup inside the triangle reads
/// only texels of the block.
std::vector<Vec2f> texcoords(std::size_t faces, int size_px, int block_px)
{
    const double near = 0.5 + inset_px;
    const double far = block_px - 0.5 - inset_px;
    std::vector<Vec2f> result;
    for (std::size_t face = 0; face < faces; ++face)
    {
        const double left = static_cast<double>(face % blocks_per_row(size_px, block_px)) * block_px;
        const double lower = static_cast<double>(face / blocks_per_row(size_px, block_px)) * block_px;
        for (const auto& [x, y] : {std::pair{near, near}, {far, near}, {near, far}})
            result.push_back({static_cast<float>((left + x) / size_px), static_cast<float>((lower + y) / size_px)});
    }
    return result;
}

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
        const auto faces = mesh->triangles.size();
        const auto room = [&](int size) { return blocks_per_row(size, *block_px) * blocks_per_row(size, *block_px); };
        if (faces > room(*size_px))
        {
            int enough = 1;
            while (room(enough) < faces)
                enough *= 2;
            throw fresco::Error(fmt::format("{} faces, but a texture of {} texels has room for {} blocks of {}: set size_px to "
                                            "{}, decimate the mesh further, or set a smaller block_px",
                                            faces, *size_px, room(*size_px), *block_px, enough));
        }
        fresco::Mesh result = *mesh;
        result.texcoords = texcoords(faces, *size_px, *block_px);
        result.charts.resize(faces);
        std::iota(result.charts.begin(), result.charts.end(), 0U);
        result.texture_px = *size_px;
        run.report("faces", static_cast<std::int64_t>(faces));
        run.report("used_share", static_cast<double>(faces) / static_cast<double>(room(*size_px)));
        atlas = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("atlas.face_blocks", AtlasFaceBlocks, "Atlas of equal blocks of texels, one per face")
