#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/texture.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

/// \file The slow, obvious twin: each texel from the definition, in double precision, on the wall of two charts.

namespace plain
{

using namespace fresco;

inline std::array<double, 3> color(const Raster8& rgb, double x, double y)
{
    const auto lobe = [](double t)
    {
        const double a = std::numbers::pi * t;
        return t == 0 ? 1.0 : std::abs(t) >= 3 ? 0.0 : 3 * std::sin(a) * std::sin(a / 3) / (a * a);
    };
    // The outermost pixels have one neighbor among those that count.
    const auto sharp = [&](double t, int k)
    { return 1.04 * lobe(t) - 0.02 * ((k > -2 ? lobe(t + 1) : 0) + (k < 3 ? lobe(t - 1) : 0)); };
    x = std::clamp(x, 0.0, rgb.width - 1.0);
    y = std::clamp(y, 0.0, rgb.height - 1.0);
    std::array<double, 3> sum{};
    double total = 0;
    for (int row = static_cast<int>(y) - 2; row <= static_cast<int>(y) + 3; ++row)
        for (int column = static_cast<int>(x) - 2; column <= static_cast<int>(x) + 3; ++column)
        {
            const double weight = sharp(x - column, column - static_cast<int>(x)) * sharp(y - row, row - static_cast<int>(y));
            total += weight;
            for (int c = 0; c < 3; ++c)
                sum[static_cast<std::size_t>(c)] +=
                    weight * rgb.at(std::clamp(column, 0, rgb.width - 1), std::clamp(row, 0, rgb.height - 1), c);
        }
    for (double& v : sum)
        v /= total;
    return sum;
}

struct Group
{
    double first_x, first_y;  ///< Where its first copy puts the middle texel's center.
    double weight = 0, x = 0, y = 0;
};

/// Of texel (column, row) of a texture of `size_px`, which lies in a texel of the map that has a place.
inline std::array<double, 3> enlarged(const SourceMap& map, const Raster8& rgb, int size_px, int column, int row)
{
    const double u = (column + 0.5) * map.size_px() / size_px;
    const double v = (row + 0.5) * map.size_px() / size_px;
    const int middle_x = static_cast<int>(std::floor(u));
    const int middle_y = static_cast<int>(std::floor(v));
    const auto spline = [](double t)
    {
        t = std::abs(t);
        return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
    };
    std::vector<Group> groups;
    // The middle first, then row by row.
    for (const int i : {4, 0, 1, 2, 3, 5, 6, 7, 8})
    {
        const int x = middle_x + i % 3 - 1;
        const int y = middle_y + i / 3 - 1;
        // The two charts of the wall lie on both sides of the middle.
        if (x < 0 || y < 0 || x >= map.size_px() || y >= map.size_px() ||
            (2 * x < map.size_px()) != (2 * middle_x < map.size_px()))
            continue;
        const auto place = map.place(x, y);
        if (!place)
            continue;
        const double step = double{map.pixels_per_texel};
        const auto at = [&](double to_x, double to_y)
        {
            const double dx = to_x - (x + 0.5);
            const double dy = to_y - (y + 0.5);
            const double cosine = std::cos(double{place->angle});
            const double sine = std::sin(double{place->angle});
            return std::array{place->at.x + step * (cosine * dx - sine * dy), place->at.y + step * (sine * dx + cosine * dy)};
        };
        const auto [first_x, first_y] = at(middle_x + 0.5, middle_y + 0.5);
        Group* own = nullptr;
        for (Group& group : groups)
            if (own == nullptr && std::hypot(group.first_x - first_x, group.first_y - first_y) <= 0.75 * step)
                own = &group;
        // A copy may continue any of those in a group; those of a group agree here.
        if (own == nullptr)
            own = &groups.emplace_back(Group{first_x, first_y});
        const double weight = spline(u - (x + 0.5)) * spline(v - (y + 0.5));
        const auto [own_x, own_y] = at(u, v);
        own->weight += weight;
        own->x += weight * own_x;
        own->y += weight * own_y;
    }
    std::array<double, 3> sum{};
    double total = 0;
    for (const Group& group : groups)
    {
        if (group.weight == 0)
            continue;
        const double weight = std::pow(group.weight, 4);
        const auto own = color(rgb, group.x / group.weight - 0.5, group.y / group.weight - 0.5);
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * own[c];
        total += weight;
    }
    for (double& v_of : sum)
        v_of = std::clamp(v_of / total, 0.0, 255.0);
    return sum;
}

}  // namespace plain
