#include <fresco/raycast/ray_finder.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaycast final : public fresco::UvMappingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "faces * 2e-6 + frames * heights_px_squares * (7e-8 / cores + 1.5e-7)",
                .memory_mb = "100 + faces * 0.0004 + heights_px_squares * 6e-5",
                .disk_mb = "frames * heights_px_squares * 2.5e-6",
                .frames = {},
                .faces = {},
                .height_squares = "heights_px_squares"};
    }
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<fresco::raycast::RayFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raycast", UvmapsRaycast, "Casts the color cameras' rays against the mesh: uv, depth and angle per pixel")
FRESCO_LIBRARY("Embree", fresco::raycast::embree_version())
