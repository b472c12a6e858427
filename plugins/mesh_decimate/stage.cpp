#include "decimate.h"

#include <fresco/geometry/mesh_stages.h>

namespace
{

class MeshDecimate final : public fresco::geometry::SimplifyingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = {.per = {{fresco::count::faces, 4e-6}}},
                .parallel_share = 0.8,
                .memory_mb = {.fixed = 10, .per = {{fresco::count::faces, 2.6e-4}}},
                .disk_mb = {.per = {{fresco::count::faces, 2.1e-5}}},
                .makes = {{fresco::count::faces, {.at_most = "max_faces"}}}};
    }
    fresco::Mesh simplify(const fresco::Mesh& mesh, std::size_t max_faces, fresco::RunContext& run) const override
    {
        return decimated(mesh, {.max_faces = max_faces}, run);
    }
};

}  // namespace

FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse down to at most max_faces triangles")
