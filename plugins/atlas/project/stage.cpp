#include <fresco/geometry/mesh_stages.h>
#include <fresco/texture.h>

namespace
{

class AtlasProject final : public fresco::geometry::AtlasStage
{
};

}  // namespace

FRESCO_STAGE("atlas.project", AtlasProject, "Atlas of angle-limited projection charts")
