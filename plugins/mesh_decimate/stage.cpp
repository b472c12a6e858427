#include "decimate.h"

#include <fresco/geometry/simplifying_stage.h>

namespace
{

class MeshDecimate final : public fresco::geometry::SimplifyingStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "0.2 + 0.000001 * faces + 0.000006 * max(faces - max_faces, 0) / cores",
                .memory_mb = "30 + 0.00026 * faces",
                .disk_mb = "0.000022 * min(faces, max_faces)",
                .frames = "",
                .faces = "min(faces, max_faces)"};
    }
    fresco::Mesh simplify(const fresco::Mesh& mesh, std::size_t max_faces, fresco::RunContext& run) const override
    {
        return decimated(mesh, {.max_faces = max_faces}, run);
    }
};

}  // namespace

FRESCO_STAGE("mesh.decimate", MeshDecimate, "Quadric edge collapse down to at most max_faces triangles")
