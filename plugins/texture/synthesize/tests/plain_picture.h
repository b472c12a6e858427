#pragma once

#include "patches.h"

#include <fresco/image.h>
#include <fresco/images/lab.h>
#include <fresco/math.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

/// \file A picture level as its description says it, in double precision and with plain loops. Keys on every second pixel: for
/// pictures of less than 12 000 keys.

namespace plain
{

using namespace fresco;

using Numbers = std::vector<double>;

inline double squared_distance(const Numbers& a, const Numbers& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

/// Eigenvectors of a symmetric matrix, those of the largest eigenvalues first (cyclic Jacobi).
inline std::vector<Numbers> eigenvectors(std::vector<Numbers> a)
{
    const std::size_t n = a.size();
    std::vector<Numbers> vectors(n, Numbers(n, 0.0));
    for (std::size_t i = 0; i < n; ++i)
        vectors[i][i] = 1;
    const auto turn = [](double& x, double& y, double c, double s)
    {
        const double before = x;
        x = c * before - s * y;
        y = s * before + c * y;
    };
    for (int sweep = 0; sweep < 15; ++sweep)
        for (std::size_t p = 0; p < n; ++p)
            for (std::size_t q = p + 1; q < n; ++q)
            {
                if (a[p][q] == 0)
                    continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1);
                for (std::size_t k = 0; k < n; ++k)
                    turn(a[k][p], a[k][q], c, t * c);
                for (std::size_t k = 0; k < n; ++k)
                {
                    turn(a[p][k], a[q][k], c, t * c);
                    turn(vectors[p][k], vectors[q][k], c, t * c);
                }
            }
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
    std::vector<Numbers> sorted;
    for (const std::size_t i : order)
        sorted.push_back(vectors[i]);
    return sorted;
}

/// A picture at any place, bilinear, pixel centers at whole numbers, clamped at its border.
template <class Picture>
Vec3d color_of(const Picture& picture, Vec2d at)
{
    const double x = std::clamp(at.x, 0.0, picture.width - 1.0);
    const double y = std::clamp(at.y, 0.0, picture.height - 1.0);
    Vec3d sum;
    for (int j = static_cast<int>(y); j <= y + 1; ++j)
        for (int i = static_cast<int>(x); i <= x + 1; ++i)
        {
            const double share = std::max(0.0, 1 - std::abs(x - i)) * std::max(0.0, 1 - std::abs(y - j));
            const auto value = [&](int c) { return static_cast<double>(picture.at(i, j, c)); };
            if (share > 0)
                sum += Vec3d{value(0), value(1), value(2)} * share;
        }
    return sum;
}

struct Picture
{
    Picture(const Raster8& rgb, double of_scale, int of_side)
        : scale(of_scale), side(of_side), lab(lab_picture(resized(rgb, static_cast<int>(std::lround(rgb.width * scale)),
                                                                  static_cast<int>(std::lround(rgb.height * scale)))))
    {
        for (int y = 0; y + side <= lab.height; y += 2)
            for (int x = 0; x + side <= lab.width; x += 2)
                keys.push_back(Vec2d{x + half(), y + half()});
        find_components();
    }

    double half() const { return side / 2; }

    Numbers values_at(Vec2d at) const
    {
        Numbers values;
        for (int j = 0; j < side; ++j)
            for (int i = 0; i < side; ++i)
                for (int c = 0; c < 3; ++c)
                    values.push_back(static_cast<double>(lab.at(static_cast<int>(std::lround(at.x) - side / 2) + i,
                                                                static_cast<int>(std::lround(at.y) - side / 2) + j, c)));
        return values;
    }

    static Vec3d mean_of(const Numbers& values)
    {
        Vec3d sum;
        for (std::size_t i = 0; i < values.size(); i += 3)
            sum += Vec3d{values[i], values[i + 1], values[i + 2]};
        return sum * (3 / static_cast<double>(values.size()));
    }

    static Numbers moved(Numbers values, Vec3d by)
    {
        for (std::size_t i = 0; i < values.size(); i += 3)
        {
            values[i] += by.x;
            values[i + 1] += by.y;
            values[i + 2] += by.z;
        }
        return values;
    }

    /// Shift of a copy: three quarters of what its mean lacks, at most 14 L*a*b*.
    Vec3d shift(const Numbers& look, Vec2d at) const
    {
        const Vec3d wanted = (mean_of(look) - mean_of(values_at(at))) * 0.75;
        return wanted * std::min(1.0, 14 / std::max(length(wanted), 1e-9));
    }

    /// Mean squared difference from a place's shifted copy, with a third of the squared shift as its price.
    double distance(const Numbers& look, Vec2d at) const
    {
        const Vec3d by = shift(look, at);
        return squared_distance(look, moved(values_at(at), by)) / static_cast<double>(look.size()) + dot(by, by) / 9;
    }

    /// With half of its mean color: squared differences of means count a quarter.
    static Numbers faded(const Numbers& values) { return moved(values, mean_of(values) * -0.5); }

    Numbers projected(const Numbers& look) const
    {
        const Numbers values = faded(look);
        Numbers result;
        for (const Numbers& component : components)
        {
            double sum = 0;
            for (std::size_t i = 0; i < values.size(); ++i)
                sum += component[i] * (values[i] - mean[i]);
            result.push_back(sum);
        }
        return result;
    }

    Vec2d inside(Vec2d at) const
    {
        return {std::clamp(at.x, half(), lab.width - 1 - half()), std::clamp(at.y, half(), lab.height - 1 - half())};
    }

    /// Nearest key; the last one of several as near.
    std::size_t key_near(Vec2d at) const
    {
        std::size_t near = 0;
        for (std::size_t k = 1; k < keys.size(); ++k)
            if (const Vec2d a = keys[k] - at, b = keys[near] - at; dot(a, a) <= dot(b, b))
                near = k;
        return near;
    }

    double scale;
    int side;
    RasterF lab;
    std::vector<Vec2d> keys;
    std::vector<Numbers> key_features;
    Numbers mean;
    std::vector<Numbers> components;

  private:
    void find_components()
    {
        mean.assign(static_cast<std::size_t>(3 * side * side), 0.0);
        std::vector<Numbers> values;
        for (const Vec2d key : keys)
            values.push_back(faded(values_at(key)));
        for (const Numbers& v : values)
            for (std::size_t i = 0; i < mean.size(); ++i)
                mean[i] += v[i] / static_cast<double>(keys.size());
        std::vector<Numbers> products(mean.size(), Numbers(mean.size(), 0.0));
        for (const Numbers& v : values)
            for (std::size_t i = 0; i < mean.size(); ++i)
                for (std::size_t j = 0; j < mean.size(); ++j)
                    products[i][j] += (v[i] - mean[i]) * (v[j] - mean[j]);
        components = eigenvectors(products);
        components.resize(std::min<std::size_t>(mean.size(), 24));
        for (const Vec2d key : keys)
            key_features.push_back(projected(values_at(key)));
    }
};

}  // namespace plain

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
