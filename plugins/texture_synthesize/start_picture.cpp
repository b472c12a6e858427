#include "start_picture.h"

#include <fresco/error.h>
#include <fresco/images/recolor.h>
#include <fresco/texturing/collapse.h>
#include <fresco/texturing/surface_fill.h>

#include <algorithm>
#include <cmath>

namespace fresco::synthesize
{

StartPicture::StartPicture(const PaintedSurface& surface, const Texture& texture, const Progress& progress) : surface_(surface)
{
    texturing::check_texture(texture);
    rgb_ = texturing::collapse(texture, progress);
    faces_ = texturing::find_texel_faces(surface.mesh, surface.charts, texture.size_px(), progress);
    std::vector<std::uint8_t> known = texture.seen.values;
    for (std::size_t texel = 0; texel < known.size(); ++texel)
    {
        known[texel] = known[texel] != 0 ? 1 : 0;
        if (faces_.inside[texel] != 0)
        {
            ++chart_texels_;
            known_texels_ += known[texel];
        }
    }
    if (known_texels_ == 0)
        throw Error("the texture on port 'start' has no texel of the mesh: check that it was made for this atlas and that its "
                    "frames see the mesh");
    texturing::fill_unseen(surface.mesh, surface.charts, faces_, known, rgb_, progress);
}

void StartPicture::recolor(const Raster8& picture)
{
    ColorMoments from;
    for (std::size_t texel = 0; texel < faces_.inside.size(); ++texel)
        if (faces_.inside[texel] != 0)
            from.add({double{rgb_.values[3 * texel]}, double{rgb_.values[3 * texel + 1]}, double{rgb_.values[3 * texel + 2]}});
    ColorMoments to;
    for (std::size_t i = 0; i + 2 < picture.values.size(); i += 3)
        to.add(Vec3d{double(picture.values[i]), double(picture.values[i + 1]), double(picture.values[i + 2])} * (1.0 / 255));
    const ColorMap map = monge_kantorovich(from, to);
    for (std::size_t i = 0; i + 2 < rgb_.values.size(); i += 3)
    {
        const Vec3d color = map({double{rgb_.values[i]}, double{rgb_.values[i + 1]}, double{rgb_.values[i + 2]}});
        const auto clamped = [](double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); };
        rgb_.values[i] = clamped(color.x);
        rgb_.values[i + 1] = clamped(color.y);
        rgb_.values[i + 2] = clamped(color.z);
    }
}

Vec3f StartPicture::bilinear(std::uint32_t chart, double x, double y, float& weight) const
{
    Vec3f sum;
    const double left = std::floor(x - 0.5);
    const double top = std::floor(y - 0.5);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
        {
            const int column = std::clamp(static_cast<int>(left) + i, 0, rgb_.width - 1);
            const int row = std::clamp(static_cast<int>(top) + j, 0, rgb_.height - 1);
            const auto texel =
                static_cast<std::size_t>(row) * static_cast<std::size_t>(rgb_.width) + static_cast<std::size_t>(column);
            if (!faces_.covered(texel) || surface_.charts.of_face[faces_.face[texel]] != chart)
                continue;
            const double across = i == 0 ? left + 1.5 - x : x - 0.5 - left;
            const double along = j == 0 ? top + 1.5 - y : y - 0.5 - top;
            // Never quite nothing, so that a lone texel of the chart counts.
            const auto share = static_cast<float>(across * along + 1e-4);
            weight += share;
            sum += Vec3f{rgb_.values[3 * texel], rgb_.values[3 * texel + 1], rgb_.values[3 * texel + 2]} * share;
        }
    return sum;
}

Vec3f StartPicture::at(std::uint32_t chart, Vec2f uv, double footprint) const
{
    const double x = double{uv.x} * rgb_.width;
    const double y = (1 - double{uv.y}) * rgb_.height;
    const double texels = footprint * rgb_.width;
    const int steps = std::clamp(static_cast<int>(std::lround(texels)), 1, 16);
    Vec3f sum;
    float weight = 0;
    for (int j = 0; j < steps; ++j)
        for (int i = 0; i < steps; ++i)
            sum += bilinear(chart, x + ((i + 0.5) / steps - 0.5) * texels, y + ((j + 0.5) / steps - 0.5) * texels, weight);
    if (weight > 0)
        return sum * (1 / weight);
    // A sliver of a chart that no texel of this size belongs to.
    const int column = std::clamp(static_cast<int>(x), 0, rgb_.width - 1);
    const int row = std::clamp(static_cast<int>(y), 0, rgb_.height - 1);
    return {rgb_.at(column, row, 0), rgb_.at(column, row, 1), rgb_.at(column, row, 2)};
}

}  // namespace fresco::synthesize
