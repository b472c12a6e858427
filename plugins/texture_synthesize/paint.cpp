#include "paint.h"

#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::synthesize
{
namespace
{

constexpr std::size_t rows_per_piece = 16;
constexpr float heaviest_share = 0.75F;  // Of the luminance.

/// RGB in [0,1]: the mean's color, lightened or darkened toward the heaviest patch's luminance (Rec. 709, of displayed values).
Vec3f mixed(const Vote& vote)
{
    const float lighter = heaviest_share * dot(Vec3f{0.2126F, 0.7152F, 0.0722F}, vote.heaviest - vote.mean);
    const auto clamped = [lighter](float v) { return std::clamp(v + lighter, 0.0F, 1.0F); };
    return {clamped(vote.mean.x), clamped(vote.mean.y), clamped(vote.mean.z)};
}

/// RGB in [0,1] of an 8-bit picture at a place, bilinear, pixel centers at whole numbers.
Vec3f color_at(const Raster8& rgb, Vec2f at)
{
    const float x = std::clamp(at.x, 0.0F, static_cast<float>(rgb.width - 1));
    const float y = std::clamp(at.y, 0.0F, static_cast<float>(rgb.height - 1));
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, rgb.width - 1);
    const int y1 = std::min(y0 + 1, rgb.height - 1);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    const auto value = [&rgb](int column, int row)
    {
        const std::uint8_t* v = &rgb.at(column, row);
        return Vec3f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
    };
    const Vec3f top = value(x0, y0) * (1 - fx) + value(x1, y0) * fx;
    const Vec3f bottom = value(x0, y1) * (1 - fx) + value(x1, y1) * fx;
    return (top * (1 - fy) + bottom * fy) * (1 / 255.0F);
}

}  // namespace

Painting paint(const Task& task, const Level& level, int size_px, Progress& progress)
{
    const Mesh& mesh = task.surface.mesh;
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, task.surface.charts, size_px, progress);
    double uv_per_m = 0;
    double weight = 0;
    for (std::uint32_t c = 0; c < task.surface.charts.count; ++c)
        if (level.grid().has_sheet(c))
        {
            const SurfaceGrid::Sheet& sheet = level.grid().sheet(c);
            const double cells = static_cast<double>(sheet.width) * sheet.height;
            uv_per_m += cells * task.surface.uv_per_m[c];
            weight += cells;
        }
    uv_per_m /= weight;
    const double texel_m = 1 / (uv_per_m * size_px);

    // Of the style picture: its pixels along a texel, and how much it is made smaller for that.
    const double pixels_per_texel = texel_m / level.grid().spacing_m() / level.picture().scale();
    const double scale = std::min(1.0, 1 / pixels_per_texel);
    const Raster8 picture = resized(task.picture, std::max(1, static_cast<int>(std::lround(task.picture.width * scale))),
                                    std::max(1, static_cast<int>(std::lround(task.picture.height * scale))));
    const RasterF& searched = level.picture().lab();
    const Vec2f to_picture{static_cast<float>(picture.width) / static_cast<float>(searched.width),
                           static_cast<float>(picture.height) / static_cast<float>(searched.height)};

    Painting result;
    const std::string atlas = atlas_id(mesh);
    result.texture.atlas = atlas;
    result.texture.layers.emplace_back(size_px, size_px, 3);
    result.texture.seen = Raster8(size_px, size_px);
    result.source.atlas = atlas;
    result.source.picture_width = task.picture.width;
    result.source.picture_height = task.picture.height;
    result.source.pixels_per_texel = static_cast<float>(pixels_per_texel);
    result.source.places = Raster16(size_px, size_px, 3, SourceMap::none);

    const auto paint_texel = [&](int x, int y)
    {
        const std::size_t texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px) + static_cast<std::size_t>(x);
        if (!faces.covered(texel))
            return;
        const std::uint32_t face = faces.face[texel];
        const std::uint32_t chart = task.surface.charts.of_face[face];
        if (!level.grid().has_sheet(chart))
            return;
        const Vec2f uv{(static_cast<float>(x) + 0.5F) / static_cast<float>(size_px),
                       1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size_px)};
        const Vote vote = level.vote_at(
            chart, uv, texturing::texel_position(mesh, faces, texel),
            [&](Vec2f at) {
                return color_at(picture, {(at.x + 0.5F) * to_picture.x - 0.5F, (at.y + 0.5F) * to_picture.y - 0.5F});
            });
        float* out = &result.texture.layers[0].at(x, y);
        const Vec3f color = mixed(vote);
        out[0] = color.x;
        out[1] = color.y;
        out[2] = color.z;
        result.texture.seen.at(x, y) = 1;
        const TangentFrame& frame = level.patches()[vote.patch].frame;
        const Vec3f right = texcoord_axes(mesh, face).first;
        const Match& match = level.matches()[vote.patch];
        const Vec2f at = match.place(vote.offset);
        const Vec2f in_picture = turned({dot(right, frame.right), dot(right, frame.down)}, match.turn);
        result.source.set_place(x, y,
                                {{(at.x + 0.5F) * static_cast<float>(task.picture.width) / static_cast<float>(searched.width),
                                  (at.y + 0.5F) * static_cast<float>(task.picture.height) / static_cast<float>(searched.height)},
                                 std::atan2(in_picture.y, in_picture.x)});
    };
    std::size_t rows_done = 0;
    constexpr int rows_per_step = 256;
    for (int first = 0; first < size_px; first += rows_per_step)
    {
        const int rows = std::min(rows_per_step, size_px - first);
        parallel_for(static_cast<std::size_t>(rows), rows_per_piece, progress.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress.check_canceled();
                         for (std::size_t y = begin; y < end; ++y)
                             for (int x = 0; x < size_px; ++x)
                                 paint_texel(x, first + static_cast<int>(y));
                     });
        rows_done += static_cast<std::size_t>(rows);
        progress.progress(static_cast<double>(rows_done), size_px, "rows");
    }
    return result;
}

}  // namespace fresco::synthesize
