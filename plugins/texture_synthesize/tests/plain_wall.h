#pragma once

#include "plain_picture.h"

#include "patches.h"

#include <array>
#include <cstdint>

/// \file What lies under the patches of a flat wall: every patch is asked about every texel and every face.

namespace plain
{

using namespace fresco::synthesize;

/// A patch over a texel, and where the texel lies on it: to the right of its center and down.
struct Covering
{
    std::size_t patch;
    Vec2d offset;
};

/// The texels and the planes of the patches are those of the level under test.
class Wall
{
  public:
    Wall(const PaintedSurface& of, const SurfaceGrid& grid_of, const Patches& patches_of)
        : surface(of), grid(grid_of), patches(patches_of), covers(grid_of.texels().size())
    {
        for (std::size_t p = 0; p < patches.count(); ++p)
        {
            find_covers(p);
            find_spots(p);
        }
    }

    std::uint32_t chart(std::size_t texel) const { return surface.charts.of_face[grid.texels()[texel].face]; }

    Vec2d texcoord(std::size_t texel) const
    {
        const SurfaceGrid::Sheet& sheet = grid.sheet(chart(texel));
        const auto cell = static_cast<int>(grid.texels()[texel].cell - sheet.first_cell);
        return {(cell % sheet.width - 0.5) / sheet.cells_per_uv + sheet.uv_low.x,
                (cell / sheet.width - 0.5) / sheet.cells_per_uv + sheet.uv_low.y};
    }

    std::size_t texel_near(std::uint32_t in_chart, Vec2d uv) const
    {
        const SurfaceGrid::Sheet& sheet = grid.sheet(in_chart);
        const Vec2d at = cell_of(sheet, uv);
        const double x = std::clamp(std::floor(at.x), 0.0, sheet.width - 1.0);
        const double y = std::clamp(std::floor(at.y), 0.0, sheet.height - 1.0);
        return grid.texel_at(sheet.first_cell + static_cast<std::size_t>(y * sheet.width + x));
    }

    Vec2d on_patch(std::size_t patch, Vec3d away) const
    {
        const TangentFrame& frame = patches[patch].frame;
        return {dot(away, vec_cast<double>(frame.right)) / grid.spacing_m(),
                dot(away, vec_cast<double>(frame.down)) / grid.spacing_m()};
    }

    Numbers sampled(std::size_t patch, const std::vector<Vec3d>& values) const
    {
        Numbers result;
        for (const Spot& spot : spots[patch])
        {
            const auto row = [&](std::size_t cell)
            { return values[grid.texel_at(cell)] * (1 - spot.across) + values[grid.texel_at(cell + 1)] * spot.across; };
            const Vec3d v = row(spot.cell) * (1 - spot.along) + row(spot.cell + spot.width) * spot.along;
            result.insert(result.end(), {v.x, v.y, v.z});
        }
        return result;
    }

    const PaintedSurface& surface;
    const SurfaceGrid& grid;
    const Patches& patches;
    std::vector<std::vector<Covering>> covers;  ///< Per texel.

  private:
    /// Between which four cells a point of a patch lies.
    struct Spot
    {
        std::size_t cell, width;
        double across, along;
    };

    static Vec2d cell_of(const SurfaceGrid::Sheet& sheet, Vec2d uv)
    {
        return {(uv.x - sheet.uv_low.x) * sheet.cells_per_uv + 1, (uv.y - sheet.uv_low.y) * sheet.cells_per_uv + 1};
    }

    void find_covers(std::size_t patch)
    {
        for (std::size_t t = 0; t < covers.size(); ++t)
        {
            const Vec2d at = on_patch(patch, vec_cast<double>(grid.texels()[t].position - patches[patch].center));
            if (std::max(std::abs(at.x), std::abs(at.y)) <= patches.side() / 2.0)
                covers[t].push_back({patch, {std::round(at.x * 1024) / 1024, std::round(at.y * 1024) / 1024}});
        }
    }

    void find_spots(std::size_t patch)
    {
        const auto side = static_cast<std::size_t>(patches.side());
        const auto point = [&](std::size_t i)
        {
            const auto half = static_cast<double>(side / 2);
            return Vec2d{static_cast<double>(i % side) - half, static_cast<double>(i / side) - half};
        };
        std::vector<Spot> found(side * side);
        std::vector<bool> is_found(found.size(), false);
        for (std::size_t i = 0; i < found.size(); ++i)
            for (std::size_t f = 0; f < surface.mesh.triangles.size() && !is_found[i]; ++f)
                is_found[i] = find_spot(patch, f, point(i), found[i]);
        std::vector<Spot> filled = found;
        for (std::size_t i = 0; i < found.size(); ++i)
        {
            double least = 1e9;
            for (std::size_t k = 0; k < found.size() && !is_found[i]; ++k)
                if (const Vec2d away = point(k) - point(i); is_found[k] && dot(away, away) < least)
                {
                    least = dot(away, away);
                    filled[i] = found[k];
                }
        }
        spots.push_back(filled);
    }

    bool find_spot(std::size_t patch, std::size_t face, Vec2d point, Spot& spot) const
    {
        std::array<Vec2d, 3> c;
        std::array<Vec2d, 3> uv;
        for (std::size_t i = 0; i < 3; ++i)
        {
            const Vec3f corner = surface.mesh.positions[surface.mesh.triangles[face][i]];
            c[i] = on_patch(patch, vec_cast<double>(corner - patches[patch].center));
            const Vec2f texcoord = surface.mesh.texcoords[3 * face + i];
            uv[i] = {static_cast<double>(texcoord.x), static_cast<double>(texcoord.y)};
        }
        const double area = cross(c[1] - c[0], c[2] - c[0]);
        const double w0 = cross(c[1] - point, c[2] - point) / area;
        const double w1 = cross(c[2] - point, c[0] - point) / area;
        if (std::min({w0, w1, 1 - w0 - w1}) < 0)
            return false;
        const SurfaceGrid::Sheet& sheet = grid.sheet(surface.charts.of_face[face]);
        const Vec2d at = cell_of(sheet, uv[0] * w0 + uv[1] * w1 + uv[2] * (1 - w0 - w1)) - Vec2d{0.5, 0.5};
        const auto width = static_cast<std::size_t>(sheet.width);
        // In steps of 1 / 256 cell.
        const auto share = [](double v) { return std::floor((v - std::floor(v)) * 256) / 256; };
        spot = {sheet.first_cell + static_cast<std::size_t>(at.y) * width + static_cast<std::size_t>(at.x), width, share(at.x),
                share(at.y)};
        return true;
    }

    std::vector<std::vector<Spot>> spots;  ///< Per patch.
};

}  // namespace plain
