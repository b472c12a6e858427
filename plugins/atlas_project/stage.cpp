#include <fresco/geometry/atlas_stage.h>

namespace
{

class AtlasProject final : public fresco::geometry::AtlasStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = "1 + 0.00001 * faces",
                .memory_mb = "60 + 0.0004 * faces",
                .disk_mb = "0.00005 * faces",
                .frames = "",
                .faces = ""};
    }
};

}  // namespace

FRESCO_STAGE("atlas.project", AtlasProject, "Atlas of angle-limited projection charts")
