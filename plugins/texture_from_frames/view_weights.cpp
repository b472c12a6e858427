#include "view_weights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fresco::from_frames
{
namespace
{

constexpr float far_away = 1e6F;
constexpr float last_resort = 1e-3F;
/// A picture is fine enough where its pixels are at most two texels wide. More resolution does not make up for a lesser angle:
/// near views would outweigh all others together where they are out of place.
constexpr double enough_pixels = 0.25;
constexpr double sensor_share = 0.05;
/// Over this share of the height a view fades out toward the picture's border.
constexpr double border_share = 0.1;
/// Beyond the margin beside a depth step trust rises over so many margins.
constexpr float rise_margins = 2;

}  // namespace

RasterF distance_to(const Raster8& marked)
{
    const int width = marked.width;
    const int height = marked.height;
    RasterF distance(width, height, 1, far_away);
    for (std::size_t i = 0; i < marked.values.size(); ++i)
        if (marked.values[i] != 0)
            distance.values[i] = 0;
    constexpr float diagonal = std::numbers::sqrt2_v<float>;
    const auto take = [&](int x, int y, int from_x, int from_y, float step)
    {
        if (from_x >= 0 && from_x < width && from_y >= 0 && from_y < height)
            distance.at(x, y) = std::min(distance.at(x, y), distance.at(from_x, from_y) + step);
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            take(x, y, x - 1, y, 1);
            take(x, y, x - 1, y - 1, diagonal);
            take(x, y, x, y - 1, 1);
            take(x, y, x + 1, y - 1, diagonal);
        }
    for (int y = height - 1; y >= 0; --y)
        for (int x = width - 1; x >= 0; --x)
        {
            take(x, y, x + 1, y, 1);
            take(x, y, x + 1, y + 1, diagonal);
            take(x, y, x, y + 1, 1);
            take(x, y, x - 1, y + 1, diagonal);
        }
    return distance;
}

ViewWeights view_weights(const UvMap& map, const PixelLinks& links, const Camera& camera, const RasterF& measured, int size_px,
                         const WeightRules& rules)
{
    const int width = map.valid.width;
    const int height = map.valid.height;
    ViewWeights result;
    result.trust = RasterF(width, height);
    result.weight = RasterF(width, height);

    Raster8 rejected(width, height);
    for (std::size_t i = 0; i < measured.values.size(); ++i)
    {
        const auto depth = static_cast<double>(map.depth.values[i]);
        const auto seen = static_cast<double>(measured.values[i]);
        if (map.valid.values[i] != 0 && seen > 0 && std::abs(seen - depth) > rules.sensor_tolerance_m + sensor_share * depth)
        {
            rejected.values[i] = 1;
            ++result.rejected_pixels;
        }
    }
    Raster8 doubtful = links.at_steps();
    for (std::size_t i = 0; i < rejected.values.size(); ++i)
        if (rejected.values[i] != 0)
            doubtful.values[i] = 1;
    const RasterF distance = distance_to(doubtful);

    const auto margin = static_cast<float>(rules.edge_margin_px * height / camera.intrinsics.height);
    const auto border = static_cast<float>(border_share * height);
    const double texels_per_m2 = std::pow(links.texture_per_m() * size_px, 2);
    const double focal_squared = camera.intrinsics.fx * camera.intrinsics.fy;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (map.valid.at(x, y) == 0)
                continue;
            float trust = 1;
            if (margin > 0)
            {
                trust = std::clamp((distance.at(x, y) - margin) / (rise_margins * margin), 0.0F, 1.0F);
                result.edge_pixels += distance.at(x, y) <= margin && rejected.at(x, y) == 0;
            }
            const int inside = std::min(std::min(x, width - 1 - x), std::min(y, height - 1 - y));
            trust *= std::min(1.0F, (static_cast<float>(inside) + 0.5F) / border);
            if (rejected.at(x, y) != 0)
                continue;
            const auto depth = static_cast<double>(map.depth.at(x, y));
            const auto cosine = static_cast<double>(map.cosine.at(x, y));
            if (!(depth > 0) || !(cosine > 0))
                continue;
            const double pixels_per_texel = focal_squared * cosine / (depth * depth) / texels_per_m2;
            result.trust.at(x, y) = trust;
            result.weight.at(x, y) =
                static_cast<float>(cosine * std::min(1.0, pixels_per_texel / enough_pixels)) * std::max(trust, last_resort);
        }
    return result;
}

}  // namespace fresco::from_frames
