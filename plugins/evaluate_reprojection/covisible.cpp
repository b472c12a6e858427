#include "covisible.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

using namespace fresco;

namespace
{
constexpr double snap_px = 1e-6;  // rounding of a projection; equal poses shall meet their own pixels

/// The index of a pixel coordinate: pixel centers at whole numbers.
double index_of(double coordinate)
{
    const double index = coordinate - 0.5;
    const double nearest = std::round(index);
    return std::abs(index - nearest) < snap_px ? nearest : index;
}

/// For an index within [0, size - 1].
void split(double index, int& first, int& second, double& share)
{
    first = static_cast<int>(index);
    share = index - first;
    second = share > 0 ? first + 1 : first;
}

Lookup lookup_at(double x, double y)
{
    Lookup lookup;
    split(x, lookup.x0, lookup.x1, lookup.share_x);
    split(y, lookup.y0, lookup.y1, lookup.share_y);
    return lookup;
}

template <class Accept>
bool all_pixels(const Lookup& lookup, const Accept& accept)
{
    return accept(lookup.x0, lookup.y0) && accept(lookup.x1, lookup.y0) && accept(lookup.x0, lookup.y1) &&
           accept(lookup.x1, lookup.y1);
}

std::optional<Lookup> match_of_paper(const ViewSurface& target, Vec3d seen)
{
    const int width = target.depth.width;
    const int height = target.depth.height;
    const double x = index_of(seen.x);
    const double y = index_of(seen.y);
    if (!(x >= 0 && x <= width - 1 && y >= 0 && y <= height - 1))
        return std::nullopt;
    const Lookup lookup = lookup_at(x, y);
    const double tolerance = 0.02 * seen.z + 0.01;
    const auto agrees = [&](int px, int py)
    { return target.inner.at(px, py) != 0 && std::abs(seen.z - double{target.depth.at(px, py)}) <= tolerance; };
    if (!all_pixels(lookup, agrees))
        return std::nullopt;
    return lookup;
}

std::optional<Lookup> match_of_released(const ViewSurface& target, Vec3d seen)
{
    const int width = target.depth.width;
    const int height = target.depth.height;
    const double x = index_of(seen.x);
    const double y = index_of(seen.y);
    if (!(x >= 0 && x < width - 1 && y >= 0 && y < height - 1))
        return std::nullopt;
    const auto displaced = [](double index, int size) { return index * (size - 1) / size; };
    const auto depth_near = [&](double px, double py)
    {
        return double{target.depth.at(static_cast<int>(std::lround(displaced(px, width))),
                                      static_cast<int>(std::lround(displaced(py, height))))};
    };
    double nearest = 1e30;
    for (const auto& [dx, dy] : std::array<std::array<int, 2>, 4>{{{0, 0}, {1, 0}, {0, 1}, {1, 1}}})
        nearest = std::min(nearest, std::abs(seen.z - depth_near(std::floor(x) + dx, std::floor(y) + dy)));
    const Lookup lookup = lookup_at(displaced(x, width), displaced(y, height));
    if (nearest > 0.1 || !all_pixels(lookup, [&](int px, int py) { return target.depth.at(px, py) > 0; }))
        return std::nullopt;
    return lookup;
}
}  // namespace

std::vector<Match> covisible(const ViewSurface& source, const ViewSurface& target, Protocol protocol)
{
    std::vector<Match> matches;
    for (int y = 0; y < source.depth.height; ++y)
        for (int x = 0; x < source.depth.width; ++x)
        {
            if (protocol == Protocol::paper ? source.inner.at(x, y) == 0 : source.depth.at(x, y) <= 0)
                continue;
            const Vec3d seen = target.camera.project(source.point(x, y));
            if (seen.z <= 0)
                continue;
            const auto lookup = protocol == Protocol::paper ? match_of_paper(target, seen) : match_of_released(target, seen);
            if (lookup)
                matches.push_back({x, y, *lookup});
        }
    return matches;
}
