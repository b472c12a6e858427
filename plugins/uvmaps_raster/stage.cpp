#include <fresco/rendering/raster_finder.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaster final : public fresco::UvMappingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per = {{fresco::count::pixels, 1e-7}}},
                .parallel_share = 1,
                .memory_mb = {.fixed = 10, .per = {{fresco::count::faces, 1.2e-4}, {fresco::count::pixels, 4e-5}}},
                .disk_mb = {.per = {{fresco::count::pixels, 1.3e-6}}},
                .makes = {{fresco::count::pixels, {.squares_of = "heights_px"}}}};
    }
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<fresco::rendering::RasterFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raster", UvmapsRaster,
             "Rasterizes the mesh for the color cameras: uv, depth and angle per pixel; needs no Embree")
