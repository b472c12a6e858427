#include <fresco/geometry/atlas.h>
#include <fresco/geometry/atlas_figures.h>
#include <fresco/geometry/atlas_stage.h>
#include <fresco/geometry/repair.h>

namespace fresco::geometry
{

void AtlasStage::run(RunContext& run)
{
    check_mesh(*mesh_, "the input mesh");
    if (*merge_limit_deg_ < *angle_limit_deg_)
        throw Error("option \"merge_limit_deg\": expected at least angle_limit_deg");
    const auto faults = count_faults(*mesh_);
    if (faults.degenerate_faces == mesh_->triangles.size())
        throw Error("no face of the mesh has any area: check how it was made");
    run.report("components", faults.components);
    run.report("degenerate_faces", faults.degenerate_faces);
    run.report("duplicate_faces", faults.duplicate_faces);
    run.report("complex_edges", faults.complex_edges);

    const Surface surface(*mesh_);
    const ChartOptions charts{.angle_limit_deg = *angle_limit_deg_, .merge_limit_deg = *merge_limit_deg_};
    const FlattenOptions options{.charts = charts, .texel_m = expected_texel_m(surface, *size_px_)};
    const auto flat = project_charts(surface, cut_into_charts(surface, charts, run), options, run,
                                     [&](FlatCharts& projected) { lay_flat(surface, projected, options, run); });
    const auto packing = pack_charts(flat, {.size_px = *size_px_, .gutter_px = *gutter_px_}, run);
    auto result = with_atlas(*mesh_, flat, packing);
    result.texture_px = *size_px_;
    report_atlas(run, atlas_figures(result, *size_px_));
    run.report("largest_angle_deg", largest_angle_deg(surface, flat));
    run.report("joined_faces", flat.unfolded_faces);
    atlas_ = std::move(result);
}

void AtlasStage::lay_flat(const Surface&, FlatCharts&, const FlattenOptions&, RunContext&) const {}

}  // namespace fresco::geometry
