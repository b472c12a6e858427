#include <fresco/geometry/mesh_stages.h>

namespace
{

class AtlasProject final : public fresco::geometry::AtlasStage
{
    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_face = 7e-6},
                .memory_mb = {.fixed = 10, .per_face = 2.8e-4},
                .disk_mb = {.per_face = 4.8e-5},
                .texels = {.squares_of = "size_px"}};
    }
};

}  // namespace

FRESCO_STAGE("atlas.project", AtlasProject, "Atlas of angle-limited projection charts")
