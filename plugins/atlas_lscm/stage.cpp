#include "conformal.h"

#include <fresco/geometry/atlas_stage.h>
#include <fresco/geometry/map_charts.h>

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
        report_mapping(run, geo::map_charts(
                                surface, flat, [](const geo::Disk& disk, const auto&) { return conformal_map(disk); },
                                options.tolerance_m(), run));
    }
};

}  // namespace

FRESCO_STAGE("atlas.lscm", AtlasLscm, "Atlas of least-squares conformal (LSCM) charts")
FRESCO_LIBRARY("CGAL", CGAL_VERSION_STR)
