#include "view_plan.h"

#include <fresco/stage.h>

using namespace fresco;

namespace
{

class FramesVirtual final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room, with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The recorded frames; their color cameras and masks are used"};
    Output<Frames> result{this, "frames", "The recorded frames, then the virtual ones, which have no pictures"};
    Option<double> target_coverage{
        this, "target_coverage", 0.9, range(0.01, 1),
        "Stop when this share is painted of the surface that free space reaches and recorded frames do not paint"};
    Option<int> max_frames{this, "max_frames", 0, range(0, 100'000),
                           "Maximum number of virtual frames; 0: as many as the target needs"};

    void run(RunContext& run) override
    {
        result = virtual_views::with_virtual_frames(*mesh, *frames,
                                                    {.target_coverage = *target_coverage, .max_frames = *max_frames}, run);
    }
};

}  // namespace

FRESCO_STAGE("frames.virtual", FramesVirtual, "Adds cameras, planned from the mesh, that see the surface nobody recorded")
FRESCO_LIBRARY("Embree", raycast::embree_version())
