#pragma once

#include "patches.h"

#include <fresco/image.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

/// \file Surfaces and pictures that are known by hand.

namespace samples
{

using namespace fresco;
using namespace fresco::synthesize;

/// A flat rectangle of columns x rows quads with vertices of its own, and where it lies in the atlas.
struct Rectangle
{
    Vec3f corner, across, along;
    Vec2f uv_corner, uv_across, uv_along;
    int columns = 1;
    int rows = 1;
};

/// Where in the atlas: turned about `middle`, `uv_per_m` texcoords along a meter.
inline Rectangle rectangle(Vec3f corner, Vec3f across, Vec3f along, Vec2f middle, float uv_per_m, double turn = 0, int quads = 1)
{
    const auto c = static_cast<float>(std::cos(turn)) * uv_per_m;
    const auto s = static_cast<float>(std::sin(turn)) * uv_per_m;
    const Vec2f u = Vec2f{c, s} * length(across);
    const Vec2f v = Vec2f{-s, c} * length(along);
    return {corner, across, along, middle - (u + v) * 0.5F, u, v, quads, quads};
}

inline void add(Mesh& mesh, const Rectangle& r)
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto share = [](int i, int count) { return static_cast<float>(i) / static_cast<float>(count); };
    for (int j = 0; j <= r.rows; ++j)
        for (int i = 0; i <= r.columns; ++i)
            mesh.positions.push_back(r.corner + r.across * share(i, r.columns) + r.along * share(j, r.rows));
    const auto uv = [&](int i, int j) { return r.uv_corner + r.uv_across * share(i, r.columns) + r.uv_along * share(j, r.rows); };
    for (int j = 0; j < r.rows; ++j)
        for (int i = 0; i < r.columns; ++i)
        {
            const auto a = first + static_cast<std::uint32_t>(j * (r.columns + 1) + i);
            const auto c = a + static_cast<std::uint32_t>(r.columns + 1);
            mesh.triangles.push_back({a, a + 1, c + 1});
            mesh.triangles.push_back({a, c + 1, c});
            for (const Vec2f at : {uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j), uv(i + 1, j + 1), uv(i, j + 1)})
                mesh.texcoords.push_back(at);
        }
}

/// A wall of 2 m x 1 m in the plane z = 0, facing +z, in two charts that join at x = 1 and are turned in the atlas: the left one
/// by `turn`, the right one by half a turn more.
inline Mesh turned_wall(double turn, int quads)
{
    Mesh mesh;
    add(mesh, rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, turn, quads));
    add(mesh, rectangle({1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.75F, 0.25F}, 0.3F, turn + std::numbers::pi, quads));
    return mesh;
}

/// Two squares of 1 m that join at the x axis: the first in the plane z = 0, the second bent out of it by `bend` radians.
inline Mesh bent_floor(double bend, int quads)
{
    Mesh mesh;
    const Vec3f up{0, static_cast<float>(std::cos(bend)), static_cast<float>(std::sin(bend))};
    add(mesh, rectangle({0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {0.25F, 0.25F}, 0.3F, 0, quads));
    add(mesh, rectangle({0, 0, 0}, {1, 0, 0}, up, {0.75F, 0.25F}, 0.3F, 0, quads));
    return mesh;
}

/// The inside of a box from the origin to `size`: floor, ceiling and walls in six charts.
inline Mesh room(Vec3f size, int quads = 3)
{
    Mesh mesh;
    const Vec3f x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
    const float scale = 0.3F / std::max({size.x, size.y, size.z});
    int placed = 0;
    const auto side = [&](Vec3f corner, Vec3f across, Vec3f along)
    {
        const auto column = static_cast<float>(placed % 3);
        const auto row = static_cast<float>(placed++ / 3);
        add(mesh, rectangle(corner, across, along, {(column + 0.5F) / 3, (row + 0.5F) / 3}, scale, 0, quads));
    };
    side({}, x, y);
    side(z, y, x);
    side({}, y, z);
    side(x, z, y);
    side({}, z, x);
    side(y, x, z);
    return mesh;
}

/// A mesh, ready to lay patches on.
struct Prepared
{
    Prepared(const Mesh& of, double spacing_m, Vec3f up = {0, 1, 0})
        : mesh(of), surface(mesh, run), upward(upright(surface, up)), grid(surface, spacing_m, run)
    {
    }

    testing::TestRun run;
    Mesh mesh;
    PaintedSurface surface;
    Upright upward;
    SurfaceGrid grid;
};

/// Soft strokes of `width_px`, lying mostly along x, dark blue at the top to bright yellow at the bottom.
inline Raster8 brush_picture(int width, int height, std::uint64_t seed, double width_px = 6)
{
    Random random(seed);
    RasterF canvas(width, height, 3, 120);
    const int strokes = static_cast<int>(width * height / (width_px * width_px) * 1.5);
    for (int i = 0; i < strokes; ++i)
    {
        const double cx = random.uniform() * width;
        const double cy = random.uniform() * height;
        const double angle = 0.5 * random.normal();
        const double share = cy / height;
        const double light = 30 * random.normal();
        const std::array<double, 3> color{40 + 190 * share + light, 60 + 130 * share + light, 120 - 40 * share + light};
        const int reach = static_cast<int>(3 * width_px);
        for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y)
            for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x)
            {
                if (x < 0 || y < 0 || x >= width || y >= height)
                    continue;
                const double along = (x - cx) * std::cos(angle) + (y - cy) * std::sin(angle);
                const double across = (y - cy) * std::cos(angle) - (x - cx) * std::sin(angle);
                const double inside = std::min(1.25 * width_px - std::abs(along), width_px / 2 - std::abs(across)) + 0.5;
                const auto cover = static_cast<float>(std::clamp(inside, 0.0, 1.0));
                for (int c = 0; c < 3; ++c)
                    canvas.at(x, y, c) += cover * (static_cast<float>(color[static_cast<std::size_t>(c)]) - canvas.at(x, y, c));
            }
    }
    Raster8 result(width, height, 3);
    for (std::size_t i = 0; i < canvas.values.size(); ++i)
        result.values[i] = static_cast<std::uint8_t>(std::clamp(canvas.values[i] + 0.5F, 0.0F, 255.0F));
    return result;
}

}  // namespace samples
