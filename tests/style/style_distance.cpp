#include "style_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace style_test
{
namespace
{

using fresco::Raster8;
using fresco::RasterF;

/// Luminance and two colour differences in [0,1] steps, so that hue counts apart from brightness.
RasterF opponent_channels(const Raster8& rgb)
{
    RasterF result(rgb.width, rgb.height, 3);
    for (int y = 0; y < rgb.height; ++y)
        for (int x = 0; x < rgb.width; ++x)
        {
            const float r = rgb.at(x, y, 0) / 255.0F;
            const float g = rgb.at(x, y, 1) / 255.0F;
            const float b = rgb.at(x, y, 2) / 255.0F;
            result.at(x, y, 0) = (r + g + b) / 3;
            result.at(x, y, 1) = r - g;
            result.at(x, y, 2) = (r + g) / 2 - b;
        }
    return result;
}

constexpr int filter_size = 5;

/// Entry (i, j) of the cosine filter of horizontal frequency u and vertical frequency v.
double cosine(int u, int v, int i, int j)
{
    return std::cos(std::numbers::pi * u * (i + 0.5) / filter_size) * std::cos(std::numbers::pi * v * (j + 0.5) / filter_size);
}

bool inside(const Raster8& mask, int x, int y)
{
    if (mask.empty())
        return true;
    for (int j = 0; j < filter_size; ++j)
        for (int i = 0; i < filter_size; ++i)
            if (mask.at(x + i, y + j) == 0)
                return false;
    return true;
}

/// Logarithm of the root mean square response of one channel to one filter.
double spread(const RasterF& channels, const Raster8& mask, int c, int u, int v)
{
    double sum = 0;
    double count = 0;
    for (int y = 0; y + filter_size <= channels.height; y += 2)
        for (int x = 0; x + filter_size <= channels.width; x += 2)
        {
            if (!inside(mask, x, y))
                continue;
            double response = 0;
            for (int j = 0; j < filter_size; ++j)
                for (int i = 0; i < filter_size; ++i)
                    response += cosine(u, v, i, j) * static_cast<double>(channels.at(x + i, y + j, c));
            sum += response * response;
            ++count;
        }
    // The floor keeps a flat picture finite: a hundredth of the smallest step of 8 bits.
    return std::log(std::sqrt(sum / std::max(count, 1.0)) + 4e-3);
}

void append_colors(const RasterF& channels, const Raster8& mask, std::vector<double>& out)
{
    std::array<double, 3> mean{};
    std::array<double, 9> square{};
    double count = 0;
    for (int y = 0; y < channels.height; ++y)
        for (int x = 0; x < channels.width; ++x)
        {
            if (!mask.empty() && mask.at(x, y) == 0)
                continue;
            ++count;
            for (int a = 0; a < 3; ++a)
            {
                mean[static_cast<std::size_t>(a)] += static_cast<double>(channels.at(x, y, a));
                for (int b = 0; b < 3; ++b)
                    square[static_cast<std::size_t>(3 * a + b)] +=
                        static_cast<double>(channels.at(x, y, a)) * static_cast<double>(channels.at(x, y, b));
            }
        }
    for (std::size_t a = 0; a < 3; ++a)
        mean[a] /= count;
    for (std::size_t a = 0; a < 3; ++a)
    {
        // Colours count about as much as the filters' logarithms.
        out.push_back(5 * mean[a]);
        out.push_back(std::log(std::sqrt(std::max(0.0, square[4 * a] / count - mean[a] * mean[a])) + 4e-3));
    }
}

RasterF blurred_luminance(const Raster8& rgb)
{
    const RasterF channels = opponent_channels(rgb);
    constexpr int radius = 9;
    std::array<float, 2 * radius + 1> kernel{};
    float total = 0;
    for (int k = -radius; k <= radius; ++k)
        total += kernel[static_cast<std::size_t>(k + radius)] = std::exp(-static_cast<float>(k * k) / 18.0F);
    RasterF rows(rgb.width, rgb.height);
    RasterF result(rgb.width, rgb.height);
    const auto convolve = [&](const auto& read, RasterF& into)
    {
        for (int y = 0; y < rgb.height; ++y)
            for (int x = 0; x < rgb.width; ++x)
                for (int k = -radius; k <= radius; ++k)
                    into.at(x, y) += kernel[static_cast<std::size_t>(k + radius)] / total * read(x, y, k);
    };
    convolve([&](int x, int y, int k) { return channels.at(std::clamp(x + k, 0, rgb.width - 1), y, 0); }, rows);
    convolve([&](int x, int y, int k) { return rows.at(x, std::clamp(y + k, 0, rgb.height - 1)); }, result);
    return result;
}

}  // namespace

std::vector<double> statistics(const Raster8& rgb, const Raster8& mask)
{
    std::vector<double> result;
    for (const int divisor : {1, 2, 4})
    {
        const RasterF channels = opponent_channels(fresco::resized(rgb, rgb.width / divisor, rgb.height / divisor));
        Raster8 small_mask = mask.empty() ? mask : fresco::resized(mask, rgb.width / divisor, rgb.height / divisor);
        append_colors(channels, small_mask, result);
        for (int c = 0; c < 3; ++c)
            for (int v = 0; v < 4; ++v)
                for (int u = 0; u < 4; ++u)
                    if (u + v > 0)
                        result.push_back(spread(channels, small_mask, c, u, v));
    }
    return result;
}

double distance(const std::vector<double>& a, const std::vector<double>& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += std::abs(a[i] - b[i]);
    return sum / static_cast<double>(a.size());
}

double gradient_correlation(const Raster8& a, const Raster8& b, const Raster8& mask)
{
    const RasterF p = blurred_luminance(a);
    const RasterF q = blurred_luminance(b);
    double pq = 0;
    double pp = 0;
    double qq = 0;
    for (int y = 1; y + 1 < a.height; ++y)
        for (int x = 1; x + 1 < a.width; ++x)
        {
            if (mask.at(x, y) == 0)
                continue;
            const auto add = [&](int dx, int dy)
            {
                const double gp = static_cast<double>(p.at(x + dx, y + dy) - p.at(x - dx, y - dy));
                const double gq = static_cast<double>(q.at(x + dx, y + dy) - q.at(x - dx, y - dy));
                pq += gp * gq;
                pp += gp * gp;
                qq += gq * gq;
            };
            add(1, 0);
            add(0, 1);
        }
    return pq / std::sqrt(std::max(pp * qq, 1e-30));
}

}  // namespace style_test
