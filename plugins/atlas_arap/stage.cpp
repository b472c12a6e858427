#include "as_rigid.h"

#include <fresco/geometry/atlas_stage.h>
#include <fresco/geometry/map_charts.h>

#include <Eigen/Core>

namespace
{

namespace geo = fresco::geometry;

class AtlasArap final : public geo::AtlasStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "1 + 0.00002 * faces",
                .memory_mb = "100 + 0.0008 * faces",
                .disk_mb = "0.00005 * faces",
                .frames = "",
                .faces = ""};
    }

    void lay_flat(const geo::Surface& surface, geo::FlatCharts& flat, const geo::FlattenOptions& options,
                  fresco::RunContext& run) const override
    {
        report_mapping(run, geo::map_charts(surface, flat, as_rigid_map, options.tolerance_m(), run));
    }
};

}  // namespace

FRESCO_STAGE("atlas.arap", AtlasArap, "Atlas of as-rigid-as-possible (ARAP) charts")
#define FRESCO_TEXT_OF(number) #number
#define FRESCO_VERSION_OF(world, major, minor) FRESCO_TEXT_OF(world) "." FRESCO_TEXT_OF(major) "." FRESCO_TEXT_OF(minor)
FRESCO_LIBRARY("Eigen", FRESCO_VERSION_OF(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION))
