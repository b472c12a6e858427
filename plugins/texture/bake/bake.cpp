#include "bake.h"

#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <algorithm>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
constexpr double steps = 5;

/// The texel or one of its eight neighbors is covered: a bilinear lookup at the chart's border can reach it.
bool near_chart(const TexelFaces& faces, std::size_t texel)
{
    const auto size = static_cast<std::size_t>(faces.size);
    const std::size_t x = texel % size;
    const std::size_t y = texel / size;
    for (std::size_t ny = y > 0 ? y - 1 : 0; ny <= std::min(y + 1, size - 1); ++ny)
        for (std::size_t nx = x > 0 ? x - 1 : 0; nx <= std::min(x + 1, size - 1); ++nx)
            if (faces.covered(ny * size + nx))
                return true;
    return false;
}

/// The texels that keep their color when the gutter is filled: the charts' own, and what was optimized beside them. A texel that
/// was not seen and only touches a chart belongs to the gutter unless it was filled: its center is outside.
std::vector<std::uint8_t> gutter_sources(const TexelFaces& faces, const std::vector<std::uint8_t>& seen, Unseen unseen)
{
    std::vector<std::uint8_t> source(seen.size());
    for (std::size_t texel = 0; texel < seen.size(); ++texel)
        source[texel] =
            faces.inside[texel] || (unseen == Unseen::fill && faces.covered(texel)) || (seen[texel] && near_chart(faces, texel));
    return source;
}
}  // namespace

Raster8 bake(const Texture& texture, const Mesh& mesh, Unseen unseen, BakeCounts& counts, Progress& progress)
{
    check_texture(texture);
    std::vector<std::uint8_t> seen = texture.seen.values;
    std::transform(seen.begin(), seen.end(), seen.begin(),
                   [](std::uint8_t s) { return s != 0 ? std::uint8_t{1} : std::uint8_t{0}; });

    RasterF rgb = collapse(texture, progress);
    progress.progress(1, steps, "steps");
    const Charts charts = find_charts(mesh);
    const TexelFaces faces = find_texel_faces(mesh, charts, texture.size_px(), progress);
    progress.progress(2, steps, "steps");

    counts = {};
    for (std::size_t texel = 0; texel < seen.size(); ++texel)
        if (faces.inside[texel])
        {
            ++counts.chart_texels;
            counts.seen_texels += seen[texel];
        }
    if (unseen == Unseen::fill && counts.chart_texels > 0)
        fill_unseen(mesh, charts, faces, seen, rgb, progress);
    progress.progress(3, steps, "steps");

    Raster8 image = to_bytes(rgb, progress);
    rgb = {};
    progress.progress(4, steps, "steps");
    fill_from_nearest(image, gutter_sources(faces, seen, unseen), progress);
    progress.progress(5, steps, "steps");
    return image;
}
