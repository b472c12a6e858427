#include "scan_mesh.h"

#include "noise.h"

#include <fresco/error.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace room
{

namespace
{

constexpr std::size_t crumb_faces = 40;
constexpr float wave_m = 0.35f;

/// Smooth noise in space, standard deviation about 1: three planes of noise.
float waves(Vec3f p, std::uint32_t seed)
{
    const float k = 1 / wave_m;
    const float sum = value_noise(p.x * k, p.y * k, seed) + value_noise(p.y * k, p.z * k, seed + 1) +
                      value_noise(p.z * k, p.x * k, seed + 2) - 1.5f;
    return sum * 2.6f;
}

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t v)
{
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

/// Whether each triangle is part of a larger piece.
std::vector<std::uint8_t> without_crumbs(const std::vector<fresco::Triangle>& triangles, std::size_t vertex_count)
{
    std::vector<std::uint32_t> parent(vertex_count);
    std::iota(parent.begin(), parent.end(), 0U);
    for (const auto& t : triangles)
        for (const auto v : {t[1], t[2]})
            parent[root_of(parent, v)] = root_of(parent, t[0]);
    std::vector<std::size_t> faces(vertex_count);
    for (const auto& t : triangles)
        ++faces[root_of(parent, t[0])];
    std::vector<std::uint8_t> result;
    result.reserve(triangles.size());
    for (const auto& t : triangles)
        result.push_back(faces[root_of(parent, t[0])] < crumb_faces ? 0 : 1);
    return result;
}

}  // namespace

fresco::Mesh noisy_mesh(const SurfaceNet& net, const Scene& scene, const LightMap& light, float edge, float noise_m,
                        std::uint32_t seed, fresco::Progress& progress)
{
    fresco::Mesh mesh;
    mesh.triangles = net.triangles;
    mesh.positions.resize(net.positions.size());
    mesh.colors.resize(net.positions.size());
    fresco::parallel_for(
        net.positions.size(), 4096, progress.threads(),
        [&](std::size_t begin, std::size_t end)
        {
            progress.check_canceled();
            for (std::size_t i = begin; i < end; ++i)
            {
                const Vec3f p = net.positions[i];
                const float shift = noise_m * (0.8f * waves(p, seed) + 0.5f * bell(hash(seed, static_cast<std::uint32_t>(i))));
                mesh.positions[i] = p + net.normals[i] * shift;
                const auto& solid = scene.solids[static_cast<std::size_t>(net.solids[i])];
                const int face = nearest_face(solid, p);
                const Vec3f color = light.shade(net.solids[i], face, face_coordinates(solid, face, p), 0.5f * edge);
                const auto level = [](float v) { return static_cast<std::uint8_t>(std::clamp(std::lround(255 * v), 0L, 255L)); };
                mesh.colors[i] = {level(color.x), level(color.y), level(color.z)};
            }
        });
    return mesh;
}

void SeenVertices::add_view(const fresco::Raster<float>& exact_depth, const fresco::Camera& camera)
{
    for (std::size_t i = 0; i < positions_.size(); ++i)
    {
        const auto pixel = camera.project(fresco::vec_cast<double>(positions_[i]));
        if (!(pixel.z > 0.05 && pixel.x >= 0 && pixel.y >= 0 && pixel.x < exact_depth.width && pixel.y < exact_depth.height))
            continue;
        const auto depth = static_cast<double>(exact_depth.at(static_cast<int>(pixel.x), static_cast<int>(pixel.y)));
        if (depth > 0 && std::abs(depth - pixel.z) < 0.015 + 0.012 * pixel.z)
            seen_[i].store(1, std::memory_order_relaxed);
    }
}

fresco::Mesh seen_part(const fresco::Mesh& mesh, const SeenVertices& seen, std::vector<Part>& parts)
{
    std::vector<fresco::Triangle> found;
    std::vector<Part> found_parts;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
        if (const auto& t = mesh.triangles[f]; seen.seen(t[0]) || seen.seen(t[1]) || seen.seen(t[2]))
        {
            found.push_back(t);
            found_parts.push_back(parts[f]);
        }
    const auto is_kept = without_crumbs(found, mesh.positions.size());
    std::vector<fresco::Triangle> kept;
    parts.clear();
    for (std::size_t f = 0; f < found.size(); ++f)
        if (is_kept[f])
        {
            kept.push_back(found[f]);
            parts.push_back(found_parts[f]);
        }
    if (kept.empty())
        throw fresco::Error("the depth camera saw no surface: set a larger frames_count or larger depth pictures");

    fresco::Mesh part;
    std::vector<std::uint32_t> renamed(mesh.positions.size(), 0xffffffffU);
    for (auto& t : kept)
        for (auto& v : t)
        {
            if (renamed[v] == 0xffffffffU)
            {
                renamed[v] = static_cast<std::uint32_t>(part.positions.size());
                part.positions.push_back(mesh.positions[v]);
                part.colors.push_back(mesh.colors[v]);
            }
            v = renamed[v];
        }
    part.triangles = std::move(kept);
    return part;
}

std::vector<Part> parts_of_faces(const SurfaceNet& net, const Scene& scene)
{
    std::vector<Part> of_vertex;
    for (std::size_t i = 0; i < net.positions.size(); ++i)
    {
        const auto& solid = scene.solids[static_cast<std::size_t>(net.solids[i])];
        constexpr int bottom = 4;
        const int face = solid.hollow ? nearest_face(solid, net.positions[i]) : 0;
        of_vertex.push_back(!solid.hollow    ? solid.part
                            : face == bottom ? Part::floor
                            : face > bottom  ? Part::ceiling
                                             : Part::walls);
    }
    std::vector<Part> result;
    for (const auto& t : net.triangles)
        result.push_back(of_vertex[t[1]] == of_vertex[t[2]] ? of_vertex[t[1]] : of_vertex[t[0]]);
    return result;
}

}  // namespace room
