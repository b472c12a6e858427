#include "conformal.h"

#include <fresco/geometry/atlas_stage.h>

#include <CGAL/version.h>

namespace
{

namespace geo = fresco::geometry;

class AtlasLscm final : public geo::AtlasStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "1 + 0.00002 * faces",
                .memory_mb = "100 + 0.0005 * faces",
                .disk_mb = "0.00005 * faces",
                .frames = "",
                .faces = ""};
    }

    void lay_flat(const geo::Surface& surface, geo::FlatCharts& flat, const geo::FlattenOptions& options,
                  fresco::RunContext& run) const override
    {
        const auto counts = lay_conformal(surface, flat, options.tolerance_m(), run);
        run.report("conformal_charts", counts.conformal);
        run.report("projected_charts", counts.fallbacks);
        run.report("single_triangles", counts.single_triangles);
        run.report("conformal_area_share", counts.conformal_area_share);
        run.report("cut_edges", counts.cut_edges);
    }
};

}  // namespace

FRESCO_STAGE("atlas.lscm", AtlasLscm, "Atlas of least squares conformal charts")
FRESCO_LIBRARY("CGAL", CGAL_VERSION_STR)
