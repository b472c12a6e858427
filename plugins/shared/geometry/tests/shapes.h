#pragma once

#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

/// \file Meshes whose measures are known, for the tests of atlas stages.

namespace shapes
{

using fresco::Mesh;
using fresco::Vec3f;

using fresco::testing::append;
using fresco::testing::box;
using fresco::testing::grid;

/// A closed sphere of radius 1: `rings` bands of `segments` quads, triangles at the poles.
inline Mesh sphere(std::uint32_t rings, std::uint32_t segments)
{
    Mesh mesh;
    mesh.positions.push_back({0, 0, 1});
    for (std::uint32_t r = 1; r < rings; ++r)
        for (std::uint32_t s = 0; s < segments; ++s)
        {
            const double polar = std::numbers::pi * r / rings;
            const double around = 2 * std::numbers::pi * s / segments;
            mesh.positions.push_back({static_cast<float>(std::sin(polar) * std::cos(around)),
                                      static_cast<float>(std::sin(polar) * std::sin(around)),
                                      static_cast<float>(std::cos(polar))});
        }
    mesh.positions.push_back({0, 0, -1});
    const auto last = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
    const auto at = [&](std::uint32_t r, std::uint32_t s) { return 1 + (r - 1) * segments + s % segments; };
    for (std::uint32_t s = 0; s < segments; ++s)
    {
        mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
        mesh.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
        for (std::uint32_t r = 1; r + 1 < rings; ++r)
        {
            mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r, s + 1)});
            mesh.triangles.push_back({at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)});
        }
    }
    return mesh;
}

/// Moves every vertex by up to `amount` in each direction, the same for the same seed.
inline void shake(Mesh& mesh, float amount, std::uint64_t seed)
{
    fresco::Random random(seed);
    const auto next = [&] { return static_cast<float>(2 * random.uniform() - 1); };
    for (auto& p : mesh.positions)
        p += Vec3f{next(), next(), next()} * amount;
}

/// A scanned room in small: floor and two walls of n x n squares each that share their edges, with bumps and noise of a third of
/// an edge.
inline Mesh noisy_corner(std::uint32_t n)
{
    // Unfolded: the floor, a wall to its left and one below it, whose common edge is there twice.
    const std::uint32_t row = 2 * n + 1;
    Mesh mesh = fresco::testing::rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2 * n, 2 * n);
    std::erase_if(mesh.triangles, [=](const auto& t)
                  { return std::ranges::all_of(t, [=](std::uint32_t v) { return v % row <= n && v / row <= n; }); });
    for (auto& t : mesh.triangles)
        for (auto& v : t)
            if (v % row == n && v / row < n)
                v = n * row + v / row;
    const auto bump = [](float x, float y)
    { return 0.15F * std::exp(-30 * ((x - 0.6F) * (x - 0.6F) + (y - 0.5F) * (y - 0.5F))); };
    for (auto& p : mesh.positions)
        p = p.x < 0 ? Vec3f{0, p.y, -p.x} : p.y < 0 ? Vec3f{p.x, 0, -p.y} : Vec3f{p.x, p.y, bump(p.x, p.y)};
    shake(mesh, 0.33F / static_cast<float>(n), 7);
    return mesh;
}

/// A closed ring of n x n squares: radii 2 and 1.
inline Mesh torus(std::uint32_t n)
{
    Mesh mesh;
    const double step = 2 * std::numbers::pi / n;
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j)
        {
            const double u = step * i;
            const double v = step * j;
            mesh.positions.push_back({static_cast<float>((2 + std::cos(v)) * std::cos(u)),
                                      static_cast<float>((2 + std::cos(v)) * std::sin(u)), static_cast<float>(std::sin(v))});
            const auto at = [&](std::uint32_t a, std::uint32_t b) { return a % n * n + b % n; };
            mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            mesh.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// A band of n squares with half a turn: one border, no outside. Radius 1, width 0.4.
inline Mesh moebius_strip(std::uint32_t n)
{
    Mesh mesh;
    for (std::uint32_t i = 0; i < n; ++i)
        for (const double side : {-0.2, 0.2})
        {
            const double around = 2 * std::numbers::pi * i / n;
            const double reach = 1 + side * std::cos(around / 2);
            mesh.positions.push_back({static_cast<float>(reach * std::cos(around)), static_cast<float>(reach * std::sin(around)),
                                      static_cast<float>(side * std::sin(around / 2))});
        }
    for (std::uint32_t i = 0; i < n; ++i)
    {
        // After one turn the sides have changed places.
        const auto at = [&](std::uint32_t k, std::uint32_t side) { return k < n ? 2 * k + side : 1 - side; };
        mesh.triangles.push_back({at(i, 0), at(i + 1, 0), at(i, 1)});
        mesh.triangles.push_back({at(i + 1, 0), at(i + 1, 1), at(i, 1)});
    }
    return mesh;
}

}  // namespace shapes
