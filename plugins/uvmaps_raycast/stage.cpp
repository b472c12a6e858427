#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaycast final : public fresco::UvMappingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.1, .per = {{fresco::count::faces, 2e-6}, {fresco::count::pixels, 9e-8}}},
                .parallel_share = 1,
                .memory_mb = {.fixed = 10, .per = {{fresco::count::faces, 1.8e-4}, {fresco::count::pixels, 2.5e-5}}},
                .disk_mb = {.per = {{fresco::count::pixels, 1.3e-6}}},
                .makes = {{fresco::count::pixels, {.squares_of = "heights_px"}}}};
    }
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<fresco::raycast::RayFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raycast", UvmapsRaycast, "Casts the color cameras' rays against the mesh: uv, depth and angle per pixel")
FRESCO_LIBRARY("Embree", fresco::raycast::embree_version())
