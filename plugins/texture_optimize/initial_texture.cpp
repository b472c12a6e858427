#include "initial_texture.h"

#include "noise_picture.h"
#include "splat.h"

#include <fresco/parallel.h>
#include <fresco/push_pull.h>
#include <fresco/torch/recolour.h>

#include <algorithm>
#include <cmath>

namespace fresco::optimize
{
namespace
{

/// Every so many valid pixels, one gives its colour to the statistics; prime, so that no image column is preferred.
constexpr std::size_t sample_distance = 7;

struct Loaded
{
    std::vector<UvMap> maps;  ///< Per level.
    RasterF camera;           ///< At the size of the last map; empty where colours are not wanted.
};

Loaded loaded(const ViewSource& source, std::size_t view, bool with_colors)
{
    Loaded result;
    for (std::size_t level = 0; level < source.level_count(); ++level)
        result.maps.push_back(source.map(view, level));
    if (!with_colors)
        return result;
    const auto& map = result.maps.back();
    const Raster8 picture = resized(source.camera(view), map.valid.width, map.valid.height);
    result.camera = RasterF(picture.width, picture.height, 3);
    std::transform(picture.values.begin(), picture.values.end(), result.camera.values.begin(),
                   [](std::uint8_t v) { return static_cast<float>(v) / 255; });
    return result;
}

Vec3d color_at(const RasterF& picture, std::size_t pixel)
{
    const float* v = picture.values.data() + 3 * pixel;
    return vec_cast<double>(Vec3f{v[0], v[1], v[2]});
}

void add_samples(ColorMoments& moments, const UvMap& map, const RasterF& camera)
{
    for (std::size_t i = 0; i < map.valid.values.size(); i += sample_distance)
        if (map.valid.values[i] != 0)
            moments.add(color_at(camera, i));
}

ColorMoments moments_of(const RasterF& picture)
{
    ColorMoments moments;
    for (std::size_t i = 0; 3 * i < picture.values.size(); ++i)
        moments.add(color_at(picture, i));
    return moments;
}

void recolour(RasterF& picture, const Raster8& covered, const ColorMap& map)
{
    for (std::size_t i = 0; i < covered.values.size(); ++i)
    {
        if (covered.values[i] == 0)
            continue;
        const Vec3d color = map(color_at(picture, i));
        picture.values[3 * i] = static_cast<float>(std::clamp(color.x, 0.0, 1.0));
        picture.values[3 * i + 1] = static_cast<float>(std::clamp(color.y, 0.0, 1.0));
        picture.values[3 * i + 2] = static_cast<float>(std::clamp(color.z, 0.0, 1.0));
    }
}

RasterF plain(int size_px, Vec3d color)
{
    RasterF picture(size_px, size_px, 3);
    for (std::size_t i = 0; i < picture.values.size(); i += 3)
    {
        picture.values[i] = static_cast<float>(color.x);
        picture.values[i + 1] = static_cast<float>(color.y);
        picture.values[i + 2] = static_cast<float>(color.z);
    }
    return picture;
}

Vec3d deviation(const ColorMoments& moments)
{
    const auto covariance = moments.covariance();
    return {std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1)), std::sqrt(covariance(2, 2))};
}

}  // namespace

InitialTexture initial_texture(const ViewSource& source, const std::vector<std::size_t>& views, const RasterF& style,
                               const std::string& init, int size_px, std::uint64_t seed, Progress& progress)
{
    const bool with_colors = init == "frames";
    TexelGatherer gatherer(size_px, with_colors);
    ColorMoments recorded;
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < views.size(); begin += batch)
    {
        progress.check_cancelled();
        std::vector<Loaded> group(std::min(batch, views.size() - begin));
        parallel_for(group.size(), 1, progress.threads(),
                     [&](std::size_t first, std::size_t last)
                     {
                         for (std::size_t i = first; i < last; ++i)
                             group[i] = loaded(source, views[begin + i], with_colors);
                     });
        for (const auto& view : group)
        {
            for (std::size_t level = 0; level + 1 < view.maps.size(); ++level)
                gatherer.mark(view.maps[level]);
            if (!with_colors)
            {
                gatherer.mark(view.maps.back());
                continue;
            }
            gatherer.add(view.maps.back(), view.camera);
            add_samples(recorded, view.maps.back(), view.camera);
        }
        progress.progress(static_cast<double>(begin + group.size()), static_cast<double>(views.size()), "views");
    }

    InitialTexture result;
    result.seen = gatherer.seen();
    if (init == "zeros")
        return result;
    const ColorMoments wanted = moments_of(style);
    if (init == "noise")
        result.picture = noise_picture(size_px, wanted.mean(), deviation(wanted), seed, progress.threads());
    else if (!with_colors)
        result.picture = plain(size_px, wanted.mean());
    if (!with_colors)
        return result;
    Raster8 covered;
    result.picture = gatherer.take_colors(covered);
    recolour(result.picture, covered, monge_kantorovich(recorded, wanted));
    if (std::none_of(covered.values.begin(), covered.values.end(), [](auto v) { return v != 0; }))
        result.picture = plain(size_px, wanted.mean());
    push_pull(result.picture, covered);
    return result;
}

}  // namespace fresco::optimize
