#include <fresco/geometry/repair.h>
#include <fresco/geometry/simplifying_stage.h>
#include <fresco/geometry/topology.h>

#include <fmt/format.h>
#include <string>

namespace fresco::geometry
{
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

void report_repair(RunContext& run, const RepairReport& repair)
{
    run.report("duplicate_faces_removed", repair.duplicate_faces);
    run.report("degenerate_faces_removed", repair.degenerate_faces);
    run.report("vertices_welded", repair.vertices_welded);
    run.report("complex_edges_repaired", repair.complex_edges);
    run.report("vertices_added", repair.vertices_added);
    run.report("faces_detached", repair.faces_detached);
    run.report("unused_vertices_removed", repair.vertices_unused);
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
    report_repair(run, repair);
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
    simplified_ = std::move(result);
}

}  // namespace fresco::geometry
