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
    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 1, .per = {{fresco::count::faces, 2e-5}}},
                .memory_mb = {.fixed = 20, .per = {{fresco::count::faces, 5e-4}}},
                .disk_mb = {.per = {{fresco::count::faces, 5e-5}}},
                .makes = {{fresco::count::texels, {.squares_of = "size_px"}}}};
    }

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
