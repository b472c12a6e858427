#include <fresco/images/stroke_width.h>

#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace fresco
{
namespace
{

constexpr int longest_side = 768;  // Measured at most at this size: strokes have a few pixels then.
constexpr int directions = 16;
constexpr int steps_per_pixel = 8;
constexpr double broad_share = 1.0 / 24;  // Sigma of the background, as a share of the shorter side.

/// Gaussian blur, borders repeated. A row at a time, so that the compiler adds several pixels at once.
RasterF smoothed(const RasterF& gray, double sigma, const Progress& progress)
{
    const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
    std::vector<double> weights;
    double total = 0;
    for (int i = -radius; i <= radius; ++i)
        total += weights.emplace_back(std::exp(-i * i / (2 * sigma * sigma)));
    const auto width = static_cast<std::size_t>(gray.width);
    /// `sources(y, i)`: the pixels that weight i is for, in a row.
    const auto along = [&](const auto& sources)
    {
        RasterF to(gray.width, gray.height);
        parallel_items(static_cast<std::size_t>(gray.height), 8, progress,
                       [&](std::size_t y)
                       {
                           std::vector<double> sums(width, 0.0);
                           const auto row = sources(static_cast<int>(y));
                           for (std::size_t i = 0; i < weights.size(); ++i)
                           {
                               const float* from = row(static_cast<int>(i));
                               for (std::size_t x = 0; x < width; ++x)
                                   sums[x] += weights[i] * from[x];
                           }
                           std::ranges::transform(sums, &to.values[y * width],
                                                  [total](double sum) { return static_cast<float>(sum / total); });
                       });
        return to;
    };
    const RasterF across = along(
        [&](int y)
        {
            std::vector<float> padded;
            for (int x = -radius; x < gray.width + radius; ++x)
                padded.push_back(gray.at(std::clamp(x, 0, gray.width - 1), y));
            return [padded = std::move(padded)](int i) { return &padded[static_cast<std::size_t>(i)]; };
        });
    return along([&](int y) { return [&, y](int i) { return &across.at(0, std::clamp(y + i - radius, 0, gray.height - 1)); }; });
}

/// Luminance less its broad part, of mean 0.
RasterF fine_light(const Raster8& rgb, const Progress& progress)
{
    const double scale = std::min(1.0, static_cast<double>(longest_side) / std::max(rgb.width, rgb.height));
    const RasterF lab = lab_picture(resized(rgb, std::max(1, static_cast<int>(std::lround(rgb.width * scale))),
                                            std::max(1, static_cast<int>(std::lround(rgb.height * scale)))));
    RasterF gray = channel(lab, 0);
    const RasterF broad = smoothed(gray, std::max(1.0, broad_share * std::min(gray.width, gray.height)), progress);
    double mean = 0;
    for (std::size_t i = 0; i < gray.values.size(); ++i)
        mean += static_cast<double>(gray.values[i] -= broad.values[i]);
    mean /= static_cast<double>(gray.values.size());
    for (float& v : gray.values)
        v -= static_cast<float>(mean);
    return gray;
}

/// Mean product of a picture with itself moved by (dx, dy), dy >= 0.
double correlation(const RasterF& gray, int dx, int dy)
{
    double sum = 0;
    std::size_t count = 0;
    const int x0 = std::max(0, -dx);
    const int x1 = std::min(gray.width, gray.width - dx);
    for (int y = 0; y + dy < gray.height; ++y)
    {
        const float* a = &gray.values[gray.index(0, y)];
        const float* b = &gray.values[gray.index(0, y + dy)] + dx;
        // Several sums at once: they need not wait for each other.
        std::array<float, 8> parts{};
        int x = x0;
        for (; x + 8 <= x1; x += 8)
            for (int i = 0; i < 8; ++i)
                parts[static_cast<std::size_t>(i)] += a[x + i] * b[x + i];
        for (; x < x1; ++x)
            parts[0] += a[x] * b[x];
        sum += static_cast<double>(((parts[0] + parts[1]) + (parts[2] + parts[3])) +
                                   ((parts[4] + parts[5]) + (parts[6] + parts[7])));
        count += static_cast<std::size_t>(std::max(x1 - x0, 0));
    }
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace

double stroke_width_px(const Raster8& rgb, const Progress& progress)
{
    const RasterF gray = fine_light(rgb, progress);
    const int reach = std::clamp(std::min(gray.width, gray.height) / 10, 2, 48);
    const int columns = 2 * reach + 1;
    // dy from 0 on; the other half is its mirror image. Few are asked for: strokes are much narrower than the reach.
    std::vector<std::optional<double>> correlations(static_cast<std::size_t>(columns) * static_cast<std::size_t>(reach + 1));
    const auto at = [&](int x, int y)
    {
        if (y < 0)
        {
            x = -x;
            y = -y;
        }
        auto& known =
            correlations[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x + reach)];
        if (!known)
        {
            progress.check_canceled();
            known = correlation(gray, x, y);
        }
        return *known;
    };
    const double half = at(0, 0) / 2;
    double least = reach;
    for (int d = 0; d < directions && half > 0; ++d)
    {
        const double angle = std::numbers::pi * d / directions;
        double before = at(0, 0);
        for (int step = 1; step < (reach - 1) * steps_per_pixel; ++step)
        {
            const double r = static_cast<double>(step) / steps_per_pixel;
            if (r - 1.0 / steps_per_pixel >= least)
                break;  // Another direction fell earlier.
            const double value =
                numerics::bilinear(numerics::between(r * std::cos(angle)), numerics::between(r * std::sin(angle)), at);
            if (value <= half)
            {
                least = std::min(least, r - (half - value) / (before - value) / steps_per_pixel);
                break;
            }
            before = value;
        }
    }
    const double enlarged = static_cast<double>(rgb.width) / gray.width;
    return std::max(2.0, 1.5 * 2 * least * enlarged);
}

}  // namespace fresco
