#include "pixel_links.h"

#include <fresco/math.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fresco::from_frames
{
namespace
{

constexpr double step_share = 0.02;
constexpr double step_m = 0.01;
/// Texture per meter between neighbors of one chart, over the view's usual one.
constexpr double most_stretch = 5;
/// Every so many links, one enters the statistics; prime, so that no image column is preferred.
constexpr std::size_t sample_distance = 7;

/// Along one row or column: pixel i is valid and has 1 / depth `inverse(i)`.
template <class Valid, class Inverse>
bool is_step(int i, int count, const Valid& valid, const Inverse& inverse)
{
    const double here = inverse(i);
    const double next = inverse(i + 1);
    double jump = std::abs(next - here);
    if (i > 0 && valid(i - 1))
        jump = std::min(jump, std::abs(next - here - (here - inverse(i - 1))));
    if (i + 2 < count && valid(i + 2))
        jump = std::min(jump, std::abs(next - here - (inverse(i + 2) - next)));
    // A change of 1 / z by j is one of z by about z² j.
    const double nearer_m = 1 / std::max(here, next);
    return jump * nearer_m > step_share + step_m / nearer_m;
}

double squared(Vec3d v)
{
    return dot(v, v);
}

}  // namespace

PixelLinks::PixelLinks(const UvMap& map, const Camera& camera) : links_(map.valid.width, map.valid.height), valid_(map.valid)
{
    link_surfaces(map);
    link_texels(map, camera);
}

void PixelLinks::link_surfaces(const UvMap& map)
{
    const int width = valid_.width;
    const int height = valid_.height;
    const auto inverse = [&](int x, int y) { return 1 / static_cast<double>(map.depth.at(x, y)); };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (valid_.at(x, y) == 0)
                continue;
            if (x + 1 < width && valid_.at(x + 1, y) != 0 &&
                !is_step(
                    x, width, [&](int i) { return valid_.at(i, y) != 0; }, [&](int i) { return inverse(i, y); }))
                links_.at(x, y) |= surface_right;
            if (y + 1 < height && valid_.at(x, y + 1) != 0 &&
                !is_step(
                    y, height, [&](int i) { return valid_.at(x, i) != 0; }, [&](int i) { return inverse(x, i); }))
                links_.at(x, y) |= surface_down;
        }
}

void PixelLinks::link_texels(const UvMap& map, const Camera& camera)
{
    const int width = valid_.width;
    const int height = valid_.height;
    const Camera own{camera.intrinsics.scaled_to(width, height), {}};
    const auto point = [&](int x, int y) { return own.ray(x + 0.5, y + 0.5) * static_cast<double>(map.depth.at(x, y)); };
    // Squared texture per meter of the link to (x + dx, y + dy).
    const auto density = [&](int x, int y, int dx, int dy)
    {
        const double du = static_cast<double>(map.uv.at(x + dx, y + dy, 0)) - static_cast<double>(map.uv.at(x, y, 0));
        const double dv = static_cast<double>(map.uv.at(x + dx, y + dy, 1)) - static_cast<double>(map.uv.at(x, y, 1));
        return (du * du + dv * dv) / squared(point(x + dx, y + dy) - point(x, y));
    };
    std::vector<double> samples;
    std::size_t number = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (has(x, y, surface_right) && number++ % sample_distance == 0)
                samples.push_back(density(x, y, 1, 0));
    if (samples.empty())
        return;
    const auto quartile = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 4);
    std::nth_element(samples.begin(), quartile, samples.end());
    texture_per_m_ = std::sqrt(*quartile);
    const double most = *quartile * most_stretch * most_stretch;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            if (has(x, y, surface_right) && density(x, y, 1, 0) <= most)
                links_.at(x, y) |= texels_right;
            if (has(x, y, surface_down) && density(x, y, 0, 1) <= most)
                links_.at(x, y) |= texels_down;
        }
}

Raster8 PixelLinks::at_steps() const
{
    Raster8 result(valid_.width, valid_.height);
    const auto mark = [&](int x, int y)
    {
        if (valid_.at(x, y) != 0)
            result.at(x, y) = 1;
    };
    for (int y = 0; y < valid_.height; ++y)
        for (int x = 0; x < valid_.width; ++x)
        {
            if (x + 1 < valid_.width && !has(x, y, surface_right))
            {
                mark(x, y);
                mark(x + 1, y);
            }
            if (y + 1 < valid_.height && !has(x, y, surface_down))
            {
                mark(x, y);
                mark(x, y + 1);
            }
        }
    return result;
}

}  // namespace fresco::from_frames
