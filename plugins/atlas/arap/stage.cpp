#include "arap.h"

#include <fresco/geometry/map_charts.h>
#include <fresco/geometry/mesh_stages.h>
#include <fresco/texture.h>

#include <Eigen/Core>

namespace
{

namespace geo = fresco::geometry;

class AtlasArap final : public geo::AtlasStage
{
    void lay_flat(const geo::Surface& surface, geo::FlatCharts& flat, const geo::FlattenOptions& options,
                  fresco::RunContext& run) const override
    {
        report_mapping(run, geo::map_charts(surface, flat, arap_map, options.tolerance_m(), run));
    }
};

}  // namespace

FRESCO_STAGE("atlas.arap", AtlasArap, "Atlas of as-rigid-as-possible (ARAP) charts")
#define FRESCO_TEXT_OF(number) #number
#define FRESCO_VERSION_OF(world, major, minor) FRESCO_TEXT_OF(world) "." FRESCO_TEXT_OF(major) "." FRESCO_TEXT_OF(minor)
FRESCO_LIBRARY("Eigen", FRESCO_VERSION_OF(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION))
