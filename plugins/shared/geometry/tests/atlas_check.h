#pragma once

#include <fresco/image.h>
#include <fresco/mesh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

/// \file The slow obvious check of an atlas: every face against every texel of its box.

struct AtlasFaults
{
    std::size_t outside = 0;          ///< Texcoords not in [0,1].
    std::size_t texels_twice = 0;     ///< Texel centers inside two faces (by more than a thousandth of a texel).
    std::size_t texels_shared = 0;    ///< Texels touched by two charts.
    std::size_t gutter_breached = 0;  ///< Touched texels with another chart within the gutter.
    std::size_t split_charts = 0;     ///< Charts whose numbers leave gaps.
    bool none() const { return outside + texels_twice + texels_shared + gutter_breached + split_charts == 0; }
};

namespace atlas_check_detail
{
/// The triangle touches the square [x, x+1] x [y, y+1]: no side of either separates them.
inline bool touches(const fresco::Vec2d (&t)[3], int x, int y)
{
    if (std::max({t[0].x, t[1].x, t[2].x}) < x || std::min({t[0].x, t[1].x, t[2].x}) > x + 1 ||
        std::max({t[0].y, t[1].y, t[2].y}) < y || std::min({t[0].y, t[1].y, t[2].y}) > y + 1)
        return false;
    const double turn = fresco::cross(t[1] - t[0], t[2] - t[0]) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k)
    {
        bool all_outside = true;
        for (int corner = 0; corner < 4; ++corner)
        {
            const fresco::Vec2d p{x + (corner & 1) * 1.0, y + (corner >> 1) * 1.0};
            all_outside = all_outside && turn * fresco::cross(t[(k + 1) % 3] - t[k], p - t[k]) < -1e-9;
        }
        if (all_outside)
            return false;
    }
    return true;
}
}  // namespace atlas_check_detail

inline AtlasFaults check_atlas(const fresco::Mesh& mesh, int size_px, int gutter_px)
{
    AtlasFaults faults;
    const auto no_chart = std::uint32_t{0xffffffff};
    fresco::Raster<std::uint32_t> owner(size_px, size_px, 1, no_chart);
    fresco::Raster<std::uint8_t> covered(size_px, size_px);
    std::vector<bool> seen(mesh.triangles.size(), false);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        seen[mesh.charts[f]] = true;
        fresco::Vec2d t[3];
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto uv = mesh.texcoords[3 * f + k];
            if (!(uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1))
                ++faults.outside;
            t[k] = {double(uv.x) * size_px, double(uv.y) * size_px};
        }
        const double area = fresco::cross(t[1] - t[0], t[2] - t[0]);
        const int x0 = static_cast<int>(std::min({t[0].x, t[1].x, t[2].x}));
        const int x1 = std::min(size_px - 1, static_cast<int>(std::max({t[0].x, t[1].x, t[2].x})));
        const int y0 = static_cast<int>(std::min({t[0].y, t[1].y, t[2].y}));
        const int y1 = std::min(size_px - 1, static_cast<int>(std::max({t[0].y, t[1].y, t[2].y})));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x)
            {
                bool inside = true;
                for (std::size_t k = 0; k < 3; ++k)
                {
                    const auto edge = t[(k + 1) % 3] - t[k];
                    const double reach = fresco::cross(edge, fresco::Vec2d{x + 0.5, y + 0.5} - t[k]) * (area < 0 ? -1 : 1);
                    inside = inside && reach > 1e-3 * std::max(fresco::length(edge), 1e-3);
                }
                if (inside && covered.at(x, y)++ == 1)
                    ++faults.texels_twice;
                if (atlas_check_detail::touches(t, x, y))
                {
                    if (owner.at(x, y) != no_chart && owner.at(x, y) != mesh.charts[f])
                        ++faults.texels_shared;
                    owner.at(x, y) = mesh.charts[f];
                }
            }
    }
    const auto highest = *std::max_element(mesh.charts.begin(), mesh.charts.end());
    for (std::uint32_t c = 0; c <= highest; ++c)
        faults.split_charts += seen[c] ? 0 : 1;
    for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
        {
            if (owner.at(x, y) == no_chart)
                continue;
            bool clear = true;
            for (int dy = -gutter_px; dy <= gutter_px && clear; ++dy)
                for (int dx = -gutter_px; dx <= gutter_px && clear; ++dx)
                {
                    const int u = x + dx;
                    const int v = y + dy;
                    if (u >= 0 && v >= 0 && u < size_px && v < size_px)
                        clear = owner.at(u, v) == no_chart || owner.at(u, v) == owner.at(x, y);
                }
            faults.gutter_breached += clear ? 0 : 1;
        }
    return faults;
}

/// Texels of every chart's faces at size_px over their projected (or true) area; all equal in an atlas at world scale.
inline double texcoord_area(const fresco::Mesh& mesh, std::size_t face)
{
    const auto p = [&](std::size_t k) { return fresco::Vec2d{mesh.texcoords[3 * face + k].x, mesh.texcoords[3 * face + k].y}; };
    return 0.5 * fresco::cross(p(1) - p(0), p(2) - p(0));
}
