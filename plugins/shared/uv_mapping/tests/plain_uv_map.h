#pragma once

#include <fresco/camera.h>
#include <fresco/mesh.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

/// \file A uv map by testing every face for every pixel: what each way of making uv maps must give, written without any of them.

namespace plain
{

using fresco::Vec3d;

struct Meeting
{
    std::size_t face = 0;
    double depth = std::numeric_limits<double>::infinity();
    double second = 0;  ///< Weight of the second corner, …
    double third = 0;   ///< … and of the third.
    bool front = false;

    bool found() const { return depth < std::numeric_limits<double>::infinity(); }
};

/// A face as Möller and Trumbore's test wants it.
struct Sides
{
    Vec3d corner;
    Vec3d to_second;
    Vec3d to_third;
};

inline std::vector<Sides> sides_of(const fresco::Mesh& mesh)
{
    std::vector<Sides> result;
    for (const auto& t : mesh.triangles)
    {
        const auto a = fresco::vec_cast<double>(mesh.positions[t[0]]);
        result.push_back(
            {a, fresco::vec_cast<double>(mesh.positions[t[1]]) - a, fresco::vec_cast<double>(mesh.positions[t[2]]) - a});
    }
    return result;
}

inline Meeting first_meeting(const std::vector<Sides>& faces, Vec3d origin, Vec3d ray)
{
    Meeting best;
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
        const auto& face = faces[f];
        const Vec3d p = cross(ray, face.to_third);
        const double volume = dot(face.to_second, p);
        if (volume == 0)
            continue;
        const Vec3d from_corner = origin - face.corner;
        const double second = dot(from_corner, p) / volume;
        if (!(second >= 0 && second <= 1))
            continue;
        const Vec3d q = cross(from_corner, face.to_second);
        const double third = dot(ray, q) / volume;
        if (!(third >= 0 && second + third <= 1))
            continue;
        const double depth = dot(face.to_third, q) / volume;
        if (depth > 0 && depth < best.depth)
            best = {f, depth, second, third, volume > 0};
    }
    return best;
}

inline void fill_pixel(const fresco::Mesh& mesh, const std::vector<fresco::Vec3f>& normals, const Meeting& met, Vec3d ray,
                       fresco::UvMap& map, int x, int y)
{
    const std::array<double, 3> weights{1 - met.second - met.third, met.second, met.third};
    fresco::Vec2d uv;
    Vec3d normal;
    for (std::size_t k = 0; k < 3; ++k)
    {
        const auto corner = mesh.texcoords[3 * met.face + k];
        uv = uv + fresco::Vec2d{corner.x, corner.y} * weights[k];
        normal += fresco::vec_cast<double>(normals[mesh.triangles[met.face][k]]) * weights[k];
    }
    map.uv.at(x, y, 0) = static_cast<float>(uv.x);
    map.uv.at(x, y, 1) = static_cast<float>(uv.y);
    map.depth.at(x, y) = static_cast<float>(met.depth);
    map.cosine.at(x, y) = static_cast<float>(std::clamp(-dot(normalized(normal), normalized(ray)), 0.0, 1.0));
    map.valid.at(x, y) = 1;
}

/// 5 cm and more behind each of eight neighbors.
inline bool through_crack(const std::vector<Meeting>& met, int width, int height, int x, int y)
{
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
        {
            if (dx == 0 && dy == 0)
                continue;
            if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height)
                return false;
            const auto at = [&](int i, int j)
            { return met[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)].depth; };
            if (!(at(x, y) > at(x + dx, y + dy) + 0.05))
                return false;
        }
    return true;
}

/// One thread.
inline fresco::UvMap uv_map(const fresco::Mesh& mesh, const fresco::Camera& camera, int height_px)
{
    fresco::Camera scaled = camera;
    scaled.intrinsics = camera.intrinsics.scaled_to(camera.intrinsics.width_at(height_px), height_px);
    const int width = scaled.intrinsics.width;
    fresco::UvMap map{fresco::RasterF(width, height_px, 2), fresco::RasterF(width, height_px), fresco::RasterF(width, height_px),
                      fresco::Raster8(width, height_px)};
    const auto faces = sides_of(mesh);
    const auto normals = fresco::vertex_normals(mesh);
    std::vector<Meeting> met;
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
            met.push_back(first_meeting(faces, scaled.world_from_camera.translation, scaled.ray(x + 0.5, y + 0.5)));
    std::size_t next = 0;
    for (int y = 0; y < height_px; ++y)
        for (int x = 0; x < width; ++x)
        {
            const Meeting& here = met[next++];
            if (here.found() && here.front && here.depth >= 0.05 && !through_crack(met, width, height_px, x, y))
                fill_pixel(mesh, normals, here, scaled.ray(x + 0.5, y + 0.5), map, x, y);
        }
    return map;
}

}  // namespace plain
