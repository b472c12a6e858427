#include "decimate_openmesh.h"

#include <fresco/geometry/mesh_stages.h>

#include <OpenMesh/Core/System/config.h>

namespace
{

class MeshDecimateOpenMesh final : public fresco::geometry::SimplifyingStage
{
    fresco::Mesh simplify(const fresco::Mesh& mesh, std::size_t max_faces, fresco::RunContext& run) const override
    {
        return decimated_openmesh(mesh, max_faces, run);
    }
};

}  // namespace

FRESCO_STAGE("mesh.decimate_openmesh", MeshDecimateOpenMesh, "OpenMesh's decimater: edge collapse onto an existing vertex")
/// "9.0" of 0x90000.
constexpr char open_mesh_version[] = {'0' + OM_GET_VER, '.', '0' + OM_GET_MAJ, '\0'};
FRESCO_LIBRARY("OpenMesh", open_mesh_version)
