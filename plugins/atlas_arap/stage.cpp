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
    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 1, .per = {{fresco::count::faces, 2e-5}}},
                .memory_mb = {.fixed = 20, .per = {{fresco::count::faces, 8e-4}}},
                .disk_mb = {.per = {{fresco::count::faces, 5e-5}}},
                .makes = {{fresco::count::texels, {.squares_of = "size_px"}}}};
    }

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
