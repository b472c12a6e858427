#include <fresco/geometry/atlas_figures.h>
#include <fresco/geometry/flatten.h>
#include <fresco/geometry/mesh_stages.h>
#include <fresco/geometry/packing.h>
#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>

#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>
#include <string>

namespace fresco::geometry
{

namespace
{

/// The largest angle, in degrees, between a projected face that has an area and its chart's direction of projection; 0 without
/// such faces.
double largest_angle_deg(const Surface& surface, const FlatCharts& flat)
{
    double least_cosine = 1;
    for (std::size_t f = 0; f < surface.areas.size(); ++f)
        if (flat.projected[f] != 0 && surface.areas[f] > 0)
            least_cosine = std::min(least_cosine, dot(surface.normals[f], flat.axes[flat.chart_of_face[f]]));
    return std::acos(std::max(least_cosine, -1.0)) * 180 / std::numbers::pi;
}

}  // namespace

Mesh projected_atlas(const Mesh& mesh, const AtlasOptions& options, RunContext& run)
{
    const Surface surface(mesh);
    const auto degenerate = std::ranges::count(surface.areas, 0.0);
    if (static_cast<std::size_t>(degenerate) == mesh.triangles.size())
        throw Error("no face of the mesh has any area: check how it was made");
    const auto counts = count_surface(mesh);
    run.report("components", counts.components);
    run.report("degenerate_faces", degenerate);
    run.report("duplicate_faces", std::ranges::count(duplicate_faces(mesh), true));
    run.report("complex_edges", counts.complex_edges);

    const ChartOptions charts{.angle_limit_deg = options.angle_limit_deg, .merge_limit_deg = options.merge_limit_deg};
    // The size of a texel when 70 % of the texture are used.
    const double area = std::accumulate(surface.areas.begin(), surface.areas.end(), 0.0);
    const FlattenOptions flatten{.charts = charts, .texel_m = std::sqrt(area / 0.7) / options.size_px};
    const auto flat = project_charts(surface, cut_into_charts(surface, charts, run), flatten, run);
    Mesh result = mesh;
    result.texcoords = pack_charts(flat, {.size_px = options.size_px}, run);
    result.charts = flat.chart_of_face;
    numerics::number_by_first(result.charts, flat.axes.size());
    result.texture_px = options.size_px;
    report_atlas(run, result, options.size_px);
    run.report("largest_angle_deg", largest_angle_deg(surface, flat));
    run.report("joined_faces", flat.unfolded_faces);
    return result;
}

namespace
{

void report_counts(RunContext& run, const std::string& when, const SurfaceCounts& counts)
{
    run.report("faces_" + when, counts.faces);
    run.report("vertices_" + when, counts.vertices);
    run.report("components_" + when, counts.components);
    run.report("border_length_m_" + when, counts.border_length_m);
    run.report("area_m2_" + when, counts.area_m2);
}

}  // namespace

void SimplifyingStage::run(RunContext& run)
{
    check_mesh(*mesh_, "the input mesh");
    if (!mesh_->texcoords.empty())
        run.message("the mesh's own texture coordinates are dropped: a simplified surface needs a new atlas");
    report_counts(run, "before", count_surface(*mesh_));

    RepairReport repair;
    auto result = repaired(*mesh_, repair, run);
    run.report("duplicate_faces_removed", repair.duplicate_faces);
    run.report("degenerate_faces_removed", repair.degenerate_faces);
    run.report("vertices_welded", repair.vertices_welded);
    run.report("complex_edges_repaired", repair.complex_edges);
    run.report("vertices_added", repair.vertices_added);
    run.report("faces_detached", repair.faces_detached);
    run.report("unused_vertices_removed", repair.vertices_unused);
    if (result.triangles.empty())
        throw Error("no face of the mesh has any area: check how it was made");
    const auto clean = count_surface(result);
    if (2 * clean.border_edges > clean.edges)
        run.warning(
            "more than half of the edges belong to one face only: if faces do not share vertices, merge equal vertices first, "
            "or nothing can be simplified");

    const auto target = static_cast<std::size_t>(*max_faces_);
    if (result.triangles.size() > target)
        result = simplify(result, target, run);
    const auto after = count_surface(result);
    report_counts(run, "after", after);
    if (after.components < clean.components)
        run.warning(fmt::format("{} of {} components were lost", clean.components - after.components, clean.components));
    if (after.faces > target)
        run.warning(fmt::format(
            "stopped at {} faces instead of {}: the {} components cannot be simplified further without losing or folding some",
            after.faces, target, clean.components));
    result.offset_m = mesh_->offset_m;
    simplified_ = std::move(result);
}

}  // namespace fresco::geometry
