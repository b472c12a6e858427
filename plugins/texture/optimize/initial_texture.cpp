#include "initial_texture.h"

#include "pictures.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::optimize
{
namespace
{

/// Every so many valid pixels, one gives its color to the statistics; prime, so that no image column is preferred.
constexpr std::size_t sample_distance = 7;

struct Loaded
{
    std::vector<UvMap> maps;  ///< Per level.
    RasterF camera;           ///< At the size of the last map; empty where colors are not wanted.
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

ColorMoments moments_of(const RasterF& picture, const Raster8& covered)
{
    ColorMoments moments;
    for (std::size_t i = 0; i < covered.values.size(); ++i)
        if (covered.values[i] != 0)
            moments.add(color_at(picture, i));
    return moments;
}

void recolor(RasterF& picture, const Raster8& covered, const ColorMap& map)
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

bool has_any(const Raster8& mask)
{
    return std::any_of(mask.values.begin(), mask.values.end(), [](auto v) { return v != 0; });
}

/// The colors of the covered texels at another size; `covered` becomes where they are then.
RasterF resampled(const RasterF& picture, Raster8& covered, int size_px)
{
    if (picture.width == size_px)
        return picture;
    RasterF weighted(picture.width, picture.height, 4);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
        if (covered.values[i] != 0)
        {
            std::copy_n(picture.values.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                        weighted.values.begin() + static_cast<std::ptrdiff_t>(4 * i));
            weighted.values[4 * i + 3] = 1;
        }
    weighted = resized(weighted, size_px, size_px);
    RasterF result(size_px, size_px, 3);
    covered = Raster8(size_px, size_px);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
        if (const float weight = weighted.values[4 * i + 3]; weight > 0)
        {
            covered.values[i] = 1;
            for (std::size_t c = 0; c < 3; ++c)
                result.values[3 * i + c] = weighted.values[4 * i + c] / weight;
        }
    return result;
}

}  // namespace

void InitialRules::check() const
{
    constexpr std::array words{"frames", "zeros", "color", "noise"};
    if (start == nullptr)
        return;
    if (init != Init::frames && !start_is_shown)
        throw Error(std::string("port 'start' is wired, but init is ") + words.at(static_cast<std::size_t>(init)) +
                    ": set init: frames, or remove the wire");
    if (start->values != "display")
        throw Error("the texture on port 'start' holds \"" + start->values +
                    "\" values; expected displayed colors (values: display), as texture.from_frames makes them");
    if (!has_any(start->seen))
        throw Error(
            "the texture on port 'start' has no texel that a frame saw: check that its uv maps and frames belong together");
    for (const RasterF& layer : start->layers)
        if (!std::all_of(layer.values.begin(), layer.values.end(), [](float v) { return std::isfinite(v); }))
            throw Error("the texture on port 'start' has values that are not finite: expected colors from 0 to 1");
}

InitialTexture initial_texture(const ViewSource& source, const std::vector<std::size_t>& views, const RasterF& style,
                               const InitialRules& rules, Progress& progress)
{
    rules.check();
    const bool gathers = rules.init == Init::frames && rules.start == nullptr;
    TexelGatherer gatherer(rules.size_px, gathers);
    ColorMoments recorded;
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < views.size(); begin += batch)
    {
        progress.check_canceled();
        std::vector<Loaded> group(std::min(batch, views.size() - begin));
        parallel_for(group.size(), 1, progress,
                     [&](std::size_t first, std::size_t last)
                     {
                         for (std::size_t i = first; i < last; ++i)
                             group[i] = loaded(source, views[begin + i], gathers);
                     });
        for (const auto& view : group)
        {
            for (std::size_t level = 0; level + 1 < view.maps.size(); ++level)
                gatherer.mark(view.maps[level]);
            if (!gathers)
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
    if (rules.init == Init::zeros)
        return result;
    const ColorMoments wanted = moments_of(style);
    if (rules.init == Init::noise)
        result.picture = noise_picture(rules.size_px, wanted.mean(), deviation(wanted), rules.seed, progress.threads());
    else if (rules.init == Init::color)
        result.picture = plain(rules.size_px, wanted.mean());
    if (rules.init != Init::frames)
        return result;
    Raster8 covered;
    if (gathers)
        result.picture = gatherer.take_colors(covered);
    else
    {
        covered = rules.start->seen;
        result.picture = resampled(displayed(*rules.start), covered, rules.size_px);
        recorded = moments_of(result.picture, covered);
    }
    recolor(result.picture, covered, monge_kantorovich(recorded, wanted));
    if (!has_any(covered))
        result.picture = plain(rules.size_px, wanted.mean());
    push_pull(result.picture, covered);
    return result;
}

}  // namespace fresco::optimize
