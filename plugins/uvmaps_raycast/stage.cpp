#include <fresco/raycast/scene.h>
#include <fresco/uv_mapping/uv_mapping_stage.h>

namespace
{
class UvmapsRaycast final : public fresco::UvMappingStage
{
    std::unique_ptr<fresco::FaceFinder> finder(const fresco::Mesh& mesh, const fresco::RunContext&) const override
    {
        return std::make_unique<fresco::raycast::RayFinder>(mesh);
    }
};
}  // namespace

FRESCO_STAGE("uvmaps.raycast", UvmapsRaycast, "Casts the color cameras' rays against the mesh: uv, depth and angle per pixel")
FRESCO_LIBRARY("Embree", fresco::raycast::embree_version())
