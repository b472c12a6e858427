#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/testing_scenes.h>

#include <cmath>
#include <random>
#include <vector>

/// \file Meshes and cameras whose uv maps can be computed by hand.

namespace cases
{

using namespace fresco;

using testing::wall;

/// Adds the face to the mesh, with new vertices and one texcoord.
inline void add_face(Mesh& mesh, Vec3f a, Vec3f b, Vec3f c, Vec2f uv = {0.5F, 0.5F})
{
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3f p : {a, b, c})
        mesh.positions.push_back(p);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.texcoords.insert(mesh.texcoords.end(), 3, uv);
}

/// A rectangle over [x0,x1] x [y0,y1] at depth z, facing the origin.
inline void add_rectangle(Mesh& mesh, float x0, float y0, float x1, float y1, float z)
{
    add_face(mesh, {x0, y0, z}, {x1, y1, z}, {x1, y0, z});
    add_face(mesh, {x0, y0, z}, {x0, y1, z}, {x1, y1, z});
}

/// A sphere's worth of bumpy faces around the origin, seen from inside: some cross any camera's plane, some are at its side.
inline Mesh cave(int rings)
{
    Mesh mesh;
    const double pi = std::acos(-1.0);
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i < 2 * rings; ++i)
        {
            const double a = pi * i / rings;
            const double b = pi * j / rings;
            const double r = 1.5 + 0.4 * std::sin(3 * a) * std::cos(5 * b);
            mesh.positions.push_back(
                vec_cast<float>(Vec3d{std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)} * r));
        }
    const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * 2 * rings + i % (2 * rings)); };
    for (int j = 0; j < rings; ++j)
        for (int i = 0; i < 2 * rings; ++i)
        {
            mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    std::mt19937 random(7);
    for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i)
    {
        const auto next = [&] { return static_cast<float>(random() % 4096) / 4096; };
        const float u = next();
        mesh.texcoords.push_back({u, next()});
    }
    return mesh;
}

/// Faces of all sizes, places and kinds: behind, across and far aside, without area, tiny, huge.
inline Mesh debris(int faces, unsigned seed)
{
    Mesh mesh;
    std::mt19937 random(seed);
    const auto coordinate = [&](double size)
    { return static_cast<float>(size * (static_cast<double>(random()) / 2147483648.0 - 1)); };
    for (int i = 0; i < faces; ++i)
    {
        const double size = std::pow(10.0, static_cast<double>(random() % 9) - 4);
        const Vec3f a{coordinate(2), coordinate(2), coordinate(2)};
        const auto near = [&] { return a + Vec3f{coordinate(size), coordinate(size), coordinate(size)}; };
        const Vec3f b = near();
        const Vec3f c = near();
        const Vec3f along = a + (b - a) * 0.5F;
        add_face(mesh, a, b, i % 7 == 0 ? along : i % 11 == 0 ? b : c, {coordinate(1), coordinate(1)});
    }
    return mesh;
}

}  // namespace cases
