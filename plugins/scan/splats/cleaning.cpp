#include "cleaning.h"

#include <fresco/numerics/numerics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace scan_splats
{
namespace
{

using namespace fresco;
using splats::Splats;

/// 5/255: a picture of 8 bits hardly shows it.
constexpr float faint_opacity = 0.02F;
/// Relative to the distance from the middle within which nine of ten Gaussians lie.
constexpr double giant_size = 0.25;
/// Gaussians as opaque as this may be larger: they are plain walls.
constexpr float wall_opacity = 0.5F;
constexpr double giant_wall_size = 0.5;
constexpr double far_off = 4;
/// Heaps are told apart by cells of this part of that distance.
constexpr double cell_size = 1.0 / 24;
/// A heap of less than this share of the largest one's Gaussians is loose.
constexpr double loose_share = 0.0025;
/// Times as long as wide.
constexpr float needle = 8;

std::array<float, 3> sizes(const Splats& splats, std::size_t i)
{
    std::array<float, 3> of{splats.scales[i].x, splats.scales[i].y, splats.scales[i].z};
    std::ranges::sort(of, std::greater{});
    return of;
}

double weight(const Splats& splats, std::size_t i)
{
    const auto of = sizes(splats, i);
    return static_cast<double>(splats.opacities[i]) * static_cast<double>(of[0]) * static_cast<double>(of[1]);
}

/// Keeps those for which `keep(i)` holds; returns the number of the others.
template <class Keep>
std::size_t keep_if(Splats& splats, const Keep& keep)
{
    std::size_t kept = 0;
    for (std::size_t i = 0; i < splats.size(); ++i)
        if (keep(i))
        {
            splats.centers[kept] = splats.centers[i];
            splats.rotations[kept] = splats.rotations[i];
            splats.scales[kept] = splats.scales[i];
            splats.opacities[kept] = splats.opacities[i];
            splats.colors[kept++] = splats.colors[i];
        }
    const std::size_t removed = splats.size() - kept;
    resize(splats, kept);
    return removed;
}

double median_along(const Splats& splats, float Vec3f::*axis)
{
    std::vector<double> values;
    for (const Vec3f center : splats.centers)
        values.push_back(static_cast<double>(center.*axis));
    return numerics::median(std::move(values));
}

/// Per Gaussian, the size of its heap: of all in cells that touch each other.
std::vector<std::size_t> heap_sizes(const Splats& splats, Vec3d middle, double cell)
{
    using Place = std::array<std::int32_t, 3>;
    std::vector<std::pair<Place, std::uint32_t>> members;
    for (std::uint32_t i = 0; i < splats.size(); ++i)
    {
        const Vec3d at = (vec_cast<double>(splats.centers[i]) - middle) * (1 / cell);
        const auto step = [](double value) { return static_cast<std::int32_t>(std::floor(value)); };
        members.push_back({{step(at.x), step(at.y), step(at.z)}, i});
    }
    std::ranges::sort(members);
    numerics::DisjointSets heaps(splats.size());
    for (std::size_t i = 0; i < members.size(); ++i)
    {
        const auto& [place, first] = members[i];
        if (i > 0 && members[i - 1].first == place)
        {
            heaps.join(members[i - 1].second, first);
            continue;
        }
        for (int neighbor = 14; neighbor < 27; ++neighbor)
        {
            const Place beside{place[0] + neighbor / 9 - 1, place[1] + neighbor / 3 % 3 - 1, place[2] + neighbor % 3 - 1};
            const auto found = std::ranges::lower_bound(members, std::pair{beside, std::uint32_t{0}});
            if (found != members.end() && found->first == beside)
                heaps.join(found->second, first);
        }
    }
    std::vector<std::size_t> counts(splats.size());
    for (std::uint32_t i = 0; i < splats.size(); ++i)
        ++counts[heaps.find(i)];
    std::vector<std::size_t> of(splats.size());
    for (std::uint32_t i = 0; i < splats.size(); ++i)
        of[i] = counts[heaps.find(i)];
    return of;
}

}  // namespace

CleanedSplats cleaned(Splats splats)
{
    CleanedSplats result{std::move(splats)};
    Splats& left = result.splats;
    result.faint = keep_if(left, [&](std::size_t i) { return left.opacities[i] >= faint_opacity; });
    if (left.size() == 0)
        return result;
    const Vec3d middle{median_along(left, &Vec3f::x), median_along(left, &Vec3f::y), median_along(left, &Vec3f::z)};
    const auto distance = [&](std::size_t i) { return length(vec_cast<double>(left.centers[i]) - middle); };
    std::vector<double> distances;
    for (std::size_t i = 0; i < left.size(); ++i)
        distances.push_back(distance(i));
    const auto most = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() * 9 / 10);
    std::ranges::nth_element(distances, most);
    const double radius = *most;
    if (!(radius > 0))
        return {.splats = std::move(left), .faint = result.faint};
    result.far = keep_if(left, [&](std::size_t i) { return distance(i) <= far_off * radius; });
    result.giant = keep_if(left,
                           [&](std::size_t i)
                           {
                               const double most_size = left.opacities[i] < wall_opacity ? giant_size : giant_wall_size;
                               return static_cast<double>(sizes(left, i)[0]) <= most_size * radius;
                           });
    double needles = 0, all = 0;
    std::vector<std::pair<double, double>> weight_by_size;
    for (std::size_t i = 0; i < left.size(); ++i)
    {
        const auto of = sizes(left, i);
        weight_by_size.emplace_back(of[0], weight(left, i));
        all += weight(left, i);
        needles += of[0] > needle * of[1] ? weight(left, i) : 0;
    }
    result.needle_share = all > 0 ? needles / all : 0;
    std::ranges::sort(weight_by_size);
    double longer = all;
    for (std::size_t i = 0; i < left.size() && longer > all / 2; ++i)
    {
        longer -= weight_by_size[i].second;
        result.coarseness = weight_by_size[i].first / radius;
    }
    const auto heaps = heap_sizes(left, middle, std::max(cell_size * radius, 1e-30));
    const double least = loose_share * static_cast<double>(heaps.empty() ? 0 : *std::ranges::max_element(heaps));
    std::size_t next = 0;
    result.loose = keep_if(left, [&](std::size_t) { return static_cast<double>(heaps[next++]) >= least; });
    return result;
}

}  // namespace scan_splats
