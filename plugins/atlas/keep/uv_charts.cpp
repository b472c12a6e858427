#include "uv_charts.h"

#include <fresco/numerics/numerics.h>

#include <cmath>

using namespace fresco::geometry;

std::vector<std::uint32_t> uv_charts(const fresco::Mesh& mesh)
{
    fresco::numerics::DisjointSets sets(mesh.triangles.size());
    const auto uv = [&](const EdgeUse& use, std::uint32_t end)
    { return mesh.texcoords[3 * std::size_t{use.face} + (use.corner + end) % 3]; };
    for_each_edge(mesh.triangles, mesh.positions.size(),
                  [&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses)
                  {
                      if (uses.size() == 2 && uses[0].forward != uses[1].forward && uv(uses[0], 0) == uv(uses[1], 1) &&
                          uv(uses[0], 1) == uv(uses[1], 0))
                          sets.join(uses[0].face, uses[1].face);
                  });
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
