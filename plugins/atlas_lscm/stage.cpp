#include "conformal.h"

#include <fresco/geometry/atlas.h>
#include <fresco/stage.h>

#include <CGAL/version.h>

namespace
{

namespace geo = fresco::geometry;

class AtlasLscm final : public fresco::Stage
{
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh; texture coordinates it has are replaced"};
    fresco::Output<fresco::Mesh> atlas{this, "atlas", "The same mesh with texture coordinates and charts"};
    fresco::Option<double> angle_limit_deg{this, "angle_limit_deg", 70.0, fresco::range(1, 89),
                                           "Largest angle between the smoothed surface normal and the mean of its chart"};
    fresco::Option<double> merge_limit_deg{this, "merge_limit_deg", 80.0, fresco::range(1, 89),
                                           "The same for single faces: crumbs join a neighbouring chart up to this angle"};
    fresco::Option<int> size_px{this, "size_px", 2048, fresco::range(64, 32768), "Texture size for which the gutter holds"};
    fresco::Option<int> gutter_px{this, "gutter_px", 4, fresco::range(0, 64), "Texels between charts at size_px"};

    fresco::Cost cost() const override
    {
        return {.seconds = "1 + 0.00002 * faces",
                .memory_mb = "100 + 0.0005 * faces",
                .disk_mb = "0.00005 * faces",
                .frames = "",
                .faces = ""};
    }

    void run(fresco::RunContext& run) override
    {
        fresco::check_mesh(*mesh, "atlas.lscm: input mesh");
        if (*merge_limit_deg < *angle_limit_deg)
            throw fresco::Error("atlas.lscm: merge_limit_deg must be at least angle_limit_deg");
        const geo::Surface surface(*mesh);
        const geo::ChartOptions charts{.angle_limit_deg = *angle_limit_deg, .merge_limit_deg = *merge_limit_deg};
        const auto partition = geo::cut_into_charts(surface, charts, run);
        const geo::FlattenOptions flatten{.charts = charts, .texel_m = geo::expected_texel_m(surface, *size_px)};
        auto flat = geo::project_charts(surface, partition, flatten, run);
        const auto counts = lay_conformal(surface, flat, flatten.tolerance_m(), run);
        run.report("conformal_charts", counts.conformal);
        run.report("projected_charts", counts.fallbacks);
        run.report("single_triangles", counts.single_triangles);
        run.report("conformal_area_share", counts.conformal_area_share);
        run.report("cut_edges", counts.cut_edges);
        const auto packing = geo::pack_charts(flat, {.size_px = *size_px, .gutter_px = *gutter_px}, run);
        const auto measures = geo::measure_atlas(surface, flat, packing);
        run.report("charts", measures.charts);
        run.report("used_share", measures.used_share);
        run.report("texels_per_cm", measures.texels_per_cm);
        run.report("seam_length_share", measures.seam_length_share);
        run.report("seam_length_m", measures.seam_length_m);
        run.report("largest_angle_deg", measures.largest_angle_deg);
        run.report("stretch_mean", measures.stretch_mean);
        run.report("squeezed_share", measures.squeezed_share);
        run.report("unfolded_faces", flat.unfolded_faces);
        atlas = geo::with_atlas(*mesh, flat, packing);
    }
};

}  // namespace

FRESCO_STAGE("atlas.lscm", AtlasLscm, "Atlas of least squares conformal charts")
FRESCO_LIBRARY("CGAL", CGAL_VERSION_STR)
