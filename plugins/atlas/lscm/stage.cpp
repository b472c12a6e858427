#include "lscm.h"

#include <fresco/geometry/map_charts.h>
#include <fresco/geometry/mesh_stages.h>
#include <fresco/texture.h>

#include <CGAL/version.h>

namespace
{

namespace geo = fresco::geometry;

class AtlasLscm final : public geo::AtlasStage
{
    void lay_flat(const geo::Surface& surface, geo::FlatCharts& flat, const geo::FlattenOptions& options,
                  fresco::RunContext& run) const override
    {
        report_mapping(run, geo::map_charts(
                                surface, flat, [](const geo::Disk& disk, const auto&) { return lscm_map(disk); },
                                options.tolerance_m(), run));
    }
};

}  // namespace

FRESCO_STAGE("atlas.lscm", AtlasLscm, "Atlas of least-squares conformal (LSCM) charts")
FRESCO_LIBRARY("CGAL", CGAL_VERSION_STR)
