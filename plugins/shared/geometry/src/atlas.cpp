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

double largest_angle_deg(const Surface& surface, const FlatCharts& flat)
{
    double least_cosine = 1;
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
        if (flat.projected[f] != 0 && surface.areas[f] > 0)
            least_cosine = std::min(least_cosine, dot(surface.normals[f], flat.axes[flat.chart_of_face[f]]));
    return std::acos(std::max(least_cosine, -1.0)) * 180 / std::numbers::pi;
}

double expected_texel_m(const Surface& surface, int size_px)
{
    double area = 0;
    for (const auto a : surface.areas)
        area += a;
    return std::sqrt(area / 0.7) / size_px;
}

}  // namespace fresco::geometry
