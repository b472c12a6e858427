#include <fresco/rendering/raster_finder.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaster final : public fresco::UvMappingStage
{
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<fresco::rendering::RasterFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raster", UvmapsRaster,
             "Rasterizes the mesh for the color cameras: uv, depth and angle per pixel; needs no Embree")
