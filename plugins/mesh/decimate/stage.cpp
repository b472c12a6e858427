#include "decimate.h"

#include <fresco/geometry/mesh_stages.h>

namespace
{

class MeshDecimate final : public fresco::geometry::SimplifyingStage
{
    fresco::Mesh simplify(const fresco::Mesh& mesh, std::size_t max_faces, fresco::RunContext& run) const override
    {
        return decimated(mesh, {.max_faces = max_faces}, run);
    }
};

}  // namespace

FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse down to at most max_faces triangles")
