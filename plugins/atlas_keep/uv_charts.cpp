#include "uv_charts.h"

#include <fresco/numerics/numerics.h>

#include <cmath>

using namespace fresco::geometry;

std::vector<std::uint32_t> uv_charts(const fresco::Mesh& mesh)
{
    const auto neighbors = face_neighbors(mesh.triangles, mesh.positions.size());
    fresco::numerics::DisjointSets sets(mesh.triangles.size());
    const auto uv_at = [&](std::uint32_t face, std::uint32_t vertex)
    {
        std::size_t k = 0;
        while (mesh.triangles[face][k] != vertex)
            ++k;
        return mesh.texcoords[3 * std::size_t{face} + k];
    };
    for (std::uint32_t f = 0; f < neighbors.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto g = neighbors[f][k];
            if (g == none)
                continue;
            const auto a = mesh.triangles[f][k];
            const auto b = mesh.triangles[f][(k + 1) % 3];
            if (uv_at(f, a) == uv_at(g, a) && uv_at(f, b) == uv_at(g, b))
                sets.join(f, g);
        }
    return sets.numbers();
}

UvMeasures measure_uv(const fresco::Mesh& mesh, double tolerance)
{
    Corners corners;
    corners.reserve(mesh.texcoords.size());
    for (const auto uv : mesh.texcoords)
        corners.push_back({static_cast<double>(uv.x), static_cast<double>(uv.y)});
    std::vector<std::uint32_t> faces(mesh.triangles.size());
    std::iota(faces.begin(), faces.end(), 0u);
    std::vector<bool> overlaps(faces.size(), false);
    for (const auto& [a, b] : find_overlaps(corners, faces, tolerance))
        overlaps[a] = overlaps[b] = true;
    UvMeasures measures;
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
        const double area = 0.5 * cross(corners[3 * f + 1] - corners[3 * f], corners[3 * f + 2] - corners[3 * f]);
        measures.used_share += std::abs(area);
        measures.overlap_share += overlaps[f] ? std::abs(area) : 0;
        measures.mirrored_share += area < 0 ? -area : 0;
    }
    if (measures.used_share > 0)
    {
        measures.overlap_share /= measures.used_share;
        measures.mirrored_share /= measures.used_share;
    }
    return measures;
}
