#include "edges.h"

#include <fresco/evaluation/statistics.h>
#include <fresco/images/filters.h>
#include <fresco/images/lab.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

using namespace fresco;

namespace
{
constexpr int height_px = 256;
constexpr double sigma_px = 3;
constexpr int edge_erosion_px = 7;
constexpr std::size_t least_pixels = 1000;

/// L* and how much of each pixel is covered, 0..1.
struct Lightness
{
    RasterF value;
    RasterF weight;
};

/// A picture at another size: RGB is averaged over covered pixels only.
Lightness lightness(const Raster8& picture, const Raster8& covered, int width)
{
    RasterF weighted(picture.width, picture.height, 4);
    const auto channels = static_cast<std::size_t>(picture.channels);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
        if (covered.values[i] != 0)
        {
            for (std::size_t c = 0; c < 3; ++c)
                weighted.values[4 * i + c] = static_cast<float>(picture.values[i * channels + c]) / 255;
            weighted.values[4 * i + 3] = 1;
        }
    weighted = resized(weighted, width, height_px);
    Lightness result{RasterF(width, height_px), channel(weighted, 3)};
    for (std::size_t i = 0; i < result.value.values.size(); ++i)
        if (const float weight = result.weight.values[i]; weight > 0)
            result.value.values[i] =
                lab_from_rgb(Vec3f{weighted.values[4 * i], weighted.values[4 * i + 1], weighted.values[4 * i + 2]} * (1 / weight))
                    .x;
    return result;
}

/// Gradients after a blur in which pixels count by `weight`.
Gradient gradient(RasterF value, const RasterF& weight, const RasterF& blurred_weight)
{
    for (std::size_t i = 0; i < value.values.size(); ++i)
        value.values[i] *= weight.values[i];
    value = blurred(value, sigma_px);
    for (std::size_t i = 0; i < value.values.size(); ++i)
        value.values[i] = blurred_weight.values[i] > 0 ? value.values[i] / blurred_weight.values[i] : 0;
    return sobel(value);
}
}  // namespace

double edge_correlation(const Raster8& view, const Raster8& covered, const Raster8& camera)
{
    const int width = std::max(1, static_cast<int>(std::lround(static_cast<double>(view.width) * height_px / view.height)));
    const Lightness seen = lightness(view, covered, width);
    const Lightness recorded = lightness(camera, Raster8(camera.width, camera.height, 1, 1), width);
    const RasterF blurred_weight = blurred(seen.weight, sigma_px);
    const Gradient a = gradient(seen.value, seen.weight, blurred_weight);
    const Gradient b = gradient(recorded.value, seen.weight, blurred_weight);

    Raster8 mask(width, height_px);
    std::ranges::transform(seen.weight.values, mask.values.begin(),
                           [](float weight) { return weight > 0.5F ? std::uint8_t{1} : std::uint8_t{0}; });
    mask = eroded(mask, edge_erosion_px);
    std::vector<double> of_view;
    std::vector<double> of_camera;
    for (std::size_t i = 0; i < mask.values.size(); ++i)
        if (mask.values[i] != 0)
        {
            of_view.insert(of_view.end(), {double{a.x.values[i]}, double{a.y.values[i]}});
            of_camera.insert(of_camera.end(), {double{b.x.values[i]}, double{b.y.values[i]}});
        }
    return of_view.size() < 2 * least_pixels ? std::numeric_limits<double>::quiet_NaN() : evaluation::pearson(of_view, of_camera);
}
