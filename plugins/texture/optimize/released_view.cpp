#include "released_view.h"

#include <fresco/images/filters.h>
#include <fresco/numerics/bilinear.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace fresco::optimize
{
namespace
{

/// How much each source pixel from `first` on gives to a target pixel, in fixed point.
struct Taps
{
    int first = 0;
    std::vector<int> weights;
};

constexpr int fixed_bits = 22;

double cubic(double x)
{
    constexpr double a = -0.5;
    x = std::abs(x);
    if (x < 1)
        return ((a + 2) * x - (a + 3)) * x * x + 1;
    return x < 2 ? (((x - 5) * x + 8) * x - 4) * a : 0;
}

std::vector<Taps> taps(int from, int to)
{
    const double step = static_cast<double>(from) / to;
    const double stretch = std::max(step, 1.0);
    const double reach = 2 * stretch;
    std::vector<Taps> all;
    for (int i = 0; i < to; ++i)
    {
        const double center = (i + 0.5) * step;
        const int first = std::max(0, static_cast<int>(center - reach + 0.5));
        const int end = std::min(from, static_cast<int>(center + reach + 0.5));
        std::vector<double> weights;
        double sum = 0;
        for (int x = first; x < end; ++x)
        {
            weights.push_back(cubic((x - center + 0.5) / stretch));
            sum += weights.back();
        }
        Taps pixel{first, {}};
        for (const double weight : weights)
            pixel.weights.push_back(static_cast<int>(std::lround(weight / sum * (1 << fixed_bits))));
        all.push_back(std::move(pixel));
    }
    return all;
}

/// Resamples the rows to `width`; columns take the place of rows in the result.
Raster8 resampled_and_turned(const Raster8& picture, int width)
{
    Raster8 result(picture.height, width, picture.channels);
    int column = 0;
    for (const Taps& pixel : taps(picture.width, width))
    {
        for (int y = 0; y < picture.height; ++y)
            for (int c = 0; c < picture.channels; ++c)
            {
                int sum = 1 << (fixed_bits - 1);
                int x = pixel.first;
                for (const int weight : pixel.weights)
                    sum += weight * picture.at(x++, y, c);
                result.at(y, column, c) = static_cast<std::uint8_t>(std::clamp(sum >> fixed_bits, 0, 255));
            }
        ++column;
    }
    return result;
}

/// Depth at (x, y) of width x height pixels, by OpenCV's linear filter, which finds its places in single precision.
double resized_depth(const Raster<double>& depth, int x, int y, int width, int height)
{
    const auto place = [](int i, int from, int to)
    {
        const double at = (i + 0.5) * (1 / (static_cast<double>(to) / from)) - 0.5;
        return numerics::between<float>(static_cast<float>(at), from);
    };
    const auto column = place(x, depth.width, width);
    const auto row = place(y, depth.height, height);
    const auto mix = [](double a, double b, float share)
    { return a * static_cast<double>(1 - share) + b * static_cast<double>(share); };
    const auto across = [&](int at) { return mix(depth.at(column.first, at), depth.at(column.second, at), column.share); };
    return mix(across(row.first), across(row.second), row.share);
}

/// The pixel of `from` under the middle of pixel `i` of `to`, as Pillow's nearest neighbor takes it.
int center_pixel(int i, int to, int from)
{
    return static_cast<int>((i + 0.5) * from / to);
}

}  // namespace

Raster8 bicubic(const Raster8& picture, int width, int height)
{
    return resampled_and_turned(resampled_and_turned(picture, width), height);
}

ReleasedView released_view(std::span<const UvMap> maps, const Raster8& camera, const Raster<double>& sensor, Protocol protocol)
{
    const bool scannet = protocol == Protocol::released_scannet;
    const UvMap& smallest = maps.front();
    const Raster8& surface = maps.back().valid;
    const int width = smallest.valid.width;
    const int height = smallest.valid.height;
    ReleasedView view{bicubic(scannet ? exported_for_stylemesh(camera) : camera, width, height), Raster<double>(width, height)};

    const Raster<double> recorded = scannet && !sensor.values.empty() ? exported_for_stylemesh(sensor) : sensor;
    const bool measured = !recorded.values.empty();
    const auto small = [&](int x, int y) { return resized_depth(recorded, x, y, width, height); };
    const auto large = [&](int x, int y) { return resized_depth(recorded, x, y, surface.width, surface.height); };
    // For a pixel without a measurement that takes part all the same: in the lowest level.
    constexpr double no_distance = 1e-6;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const int column = center_pixel(x, width, surface.width);
            const int row = center_pixel(y, height, surface.height);
            if (surface.at(column, row) == 0 || (scannet && measured && !(large(column, row) > 0)))
                continue;
            view.depth.at(x, y) = std::max(no_distance, measured ? small(x, y) : static_cast<double>(smallest.depth.at(x, y)));
        }
    return view;
}

}  // namespace fresco::optimize
