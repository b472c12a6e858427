#include "covering.h"

#include <fresco/stage.h>

using namespace fresco;

namespace
{

class FramesCover final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The room, with texcoords, as an atlas.* stage makes it"};
    Input<Frames> frames{this, "frames", "The frames to choose from; their color cameras and masks are used"};
    Output<Frames> chosen{this, "frames", "The chosen frames, in the same order"};
    Option<double> target_coverage{this, "target_coverage", 0.99, range(0.01, 1),
                                   "Stop when this share of all visible cells is covered"};
    Option<int> max_frames{this, "max_frames", 0, range(0, 10'000'000),
                           "Maximum number of frames; 0: as many as the target needs"};
    Option<double> max_share{this, "max_share", 1, range(1e-6, 1), "Maximum share of the frames"};
    Slot<ImageIo> images{this, optional, "Reads pictures that are not NPY; none: all are NPY"};

    void run(RunContext& run) override
    {
        chosen = cover::covering_frames(*mesh, *frames,
                                        {.target_coverage = *target_coverage, .max_frames = *max_frames, .max_share = *max_share},
                                        images.has_value() ? images.get().get() : nullptr, run);
    }
};

}  // namespace

FRESCO_STAGE("frames.cover", FramesCover, "Chooses the fewest frames that see all of the mesh sharply and from good angles")
