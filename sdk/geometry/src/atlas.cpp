#include <fresco/geometry/atlas.h>

#include <cmath>
#include <numbers>

namespace fresco::geometry
{

Mesh with_atlas(const Mesh& mesh, const FlatCharts& flat, const Packing& packing)
{
    Mesh out = mesh;
    out.texcoords = packing.texcoords;
    out.charts.resize(flat.chart_of_face.size());
    std::vector<std::uint32_t> number(flat.count, none);
    std::uint32_t next = 0;
    for (std::size_t f = 0; f < out.charts.size(); ++f)
    {
        auto& n = number[flat.chart_of_face[f]];
        if (n == none)
            n = next++;
        out.charts[f] = n;
    }
    return out;
}

AtlasMeasures measure_atlas(const Surface& surface, const FlatCharts& flat, const Packing& packing)
{
    AtlasMeasures measures;
    std::vector<bool> seen(flat.count, false);
    double inner = 0;
    double least_cosine = 1;
    double area = 0;
    double flat_area = 0;
    double squeezed = 0;
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
    {
        if (!seen[flat.chart_of_face[f]])
            ++measures.charts;
        seen[flat.chart_of_face[f]] = true;
        const auto* c = &flat.corners[3 * f];
        const double laid = 0.5 * std::abs(cross(c[1] - c[0], c[2] - c[0]));
        if (flat.projected[f] != 0 && surface.areas[f] > 0)
            least_cosine = std::min(least_cosine, dot(surface.normals[f], flat.axes[flat.chart_of_face[f]]));
        area += surface.areas[f];
        flat_area += laid;
        squeezed += 4 * laid < surface.areas[f] ? surface.areas[f] : 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (const auto g = surface.neighbours[f][k]; g != none && g > f)
            {
                const auto& t = surface.mesh.triangles[f];
                const auto edge =
                    static_cast<double>(length(surface.mesh.positions[t[(k + 1) % 3]] - surface.mesh.positions[t[k]]));
                inner += edge;
                measures.seam_length_m += flat.chart_of_face[g] != flat.chart_of_face[f] ? edge : 0;
            }
    }
    measures.used_share = packing.used_share;
    measures.texels_per_cm = packing.texels_per_m / 100;
    measures.seam_length_share = inner > 0 ? measures.seam_length_m / inner : 0;
    measures.largest_angle_deg = std::acos(std::max(least_cosine, -1.0)) * 180 / std::numbers::pi;
    measures.stretch_mean = flat_area > 0 ? area / flat_area : 0;
    measures.squeezed_share = area > 0 ? squeezed / area : 0;
    return measures;
}

double expected_texel_m(const Surface& surface, int size_px)
{
    double area = 0;
    for (const auto a : surface.areas)
        area += a;
    return std::sqrt(area / 0.7) / size_px;
}

}  // namespace fresco::geometry
