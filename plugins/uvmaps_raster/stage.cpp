#include "raster_finder.h"

#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaster final : public fresco::UvMappingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "frames * (faces * 2e-8 + heights_px_squares * 2e-8) / cores + frames * heights_px_squares * 1.5e-7",
                .memory_mb = "60 + faces * (0.00005 + heights_px_count * 0.00005) + heights_px_squares * 6e-5",
                .disk_mb = "frames * heights_px_squares * 2.5e-6",
                .frames = {},
                .faces = {},
                .height_squares = "heights_px_squares"};
    }
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<RasterFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raster", UvmapsRaster,
             "Rasterizes the mesh for the color cameras: uv, depth and angle per pixel; needs no Embree")
