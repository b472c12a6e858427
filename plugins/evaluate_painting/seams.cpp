#include "seams.h"

#include <fresco/images/lab.h>
#include <fresco/parallel.h>
#include <fresco/texturing/collapse.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

using namespace fresco;

namespace
{
constexpr std::size_t pairs_per_piece = 8192;

/// The four texels of a bilinear lookup, clamped at the borders.
struct Footprint
{
    int x0, x1, y0, y1;
    float share_x, share_y;

    Footprint(Vec2f uv, int size)
    {
        const auto split = [size](float along, int& low, int& high, float& share)
        {
            const double at = std::clamp(double{along} * size - 0.5, 0.0, size - 1.0);
            low = static_cast<int>(at);
            high = std::min(low + 1, size - 1);
            share = static_cast<float>(at - low);
        };
        split(uv.x, x0, x1, share_x);
        split(1 - uv.y, y0, y1, share_y);
    }

    template <class T>
    float value(const Raster<T>& raster, int channel) const
    {
        const auto mean = [&](int y)
        {
            return static_cast<float>(raster.at(x0, y, channel)) * (1 - share_x) +
                   static_cast<float>(raster.at(x1, y, channel)) * share_x;
        };
        return mean(y0) * (1 - share_y) + mean(y1) * share_y;
    }
};

/// The sum of differences over pairs that have one, and their number.
struct Sum
{
    double differences = 0;
    std::size_t count = 0;
};

/// `color_at`: a place's L*a*b*, nothing where it is not known.
template <class ColorAt>
Sum sum_of(std::span<const TexcoordPair> pairs, const ColorAt& color_at, const Progress& progress)
{
    std::vector<Sum> pieces((pairs.size() + pairs_per_piece - 1) / pairs_per_piece);
    parallel_for(pairs.size(), pairs_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     Sum& sum = pieces[begin / pairs_per_piece];
                     for (const TexcoordPair& pair : pairs.subspan(begin, end - begin))
                     {
                         const std::optional<Vec3f> a = color_at(pair.first);
                         const std::optional<Vec3f> b = color_at(pair.second);
                         if (!a || !b)
                             continue;
                         sum.differences += double{length(*a - *b)};
                         ++sum.count;
                     }
                 });
    Sum all;
    for (const Sum& piece : pieces)
    {
        all.differences += piece.differences;
        all.count += piece.count;
    }
    return all;
}

template <class ColorAt>
SeamFigures figures_of(const SeamPairs& pairs, const ColorAt& color_at, const Progress& progress)
{
    const Sum across = sum_of(std::span(pairs.across), color_at, progress);
    const Sum inside = sum_of(std::span(pairs.inside), color_at, progress);
    const auto mean = [](const Sum& sum)
    { return sum.count > 0 ? sum.differences / static_cast<double>(sum.count) : std::numeric_limits<double>::quiet_NaN(); };
    return {mean(across), mean(inside), across.count, inside.count};
}
}  // namespace

double SeamFigures::ratio() const
{
    return inside > 0 ? across / inside : std::numeric_limits<double>::quiet_NaN();
}

SeamFigures seam_figures(const SeamPairs& pairs, const Raster8& picture, const Progress& progress)
{
    const auto color_at = [&](Vec2f uv) -> std::optional<Vec3f>
    {
        const Footprint at(uv, picture.width);
        return lab_from_rgb(Vec3f{at.value(picture, 0), at.value(picture, 1), at.value(picture, 2)} * (1 / 255.0F));
    };
    return figures_of(pairs, color_at, progress);
}

SeamFigures seam_figures(const SeamPairs& pairs, const Texture& texture, const Progress& progress)
{
    texturing::check_texture(texture);
    const RasterF picture = texturing::collapse(texture, progress);
    const auto color_at = [&](Vec2f uv) -> std::optional<Vec3f>
    {
        const Footprint at(uv, picture.width);
        for (const int y : {at.y0, at.y1})
            for (const int x : {at.x0, at.x1})
                if (texture.seen.at(x, y) == 0)
                    return std::nullopt;
        return lab_from_rgb({at.value(picture, 0), at.value(picture, 1), at.value(picture, 2)});
    };
    return figures_of(pairs, color_at, progress);
}
