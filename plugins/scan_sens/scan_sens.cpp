#include "sens_frames.h"

#include <fresco/component.h>
#include <fresco/stage.h>

#include <zlib.h>

namespace
{

class ScanSens final : public fresco::Stage
{
    fresco::Option<fresco::InputFile> path{this, "path", fresco::required, "The recording, scene….sens"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th frame"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The recorded views, color and depth camera each"};

    void run(fresco::RunContext& run) override
    {
        const sens::SensFile file(path->path);
        const auto index = sens::read_index(file);
        auto extracted = sens::extract_frames(file, index, *every, *images, frames.folder().path, run);
        const auto count = extracted.frames.frames.size();
        run.report("recorded", index.frames.size());
        run.report("frames", count);
        run.report("poses_not_tracked", extracted.not_tracked);
        run.message(std::to_string(count) + " of " + std::to_string(index.frames.size()) + " frames, " +
                    std::to_string(extracted.not_tracked) + " left out because their pose is not finite");
        frames = std::move(extracted.frames);
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.per_frame = 0.05},
                .parallel_share = 1,
                .memory_mb = {.fixed = 60, .per_core = 15},
                .disk_mb = {.per_frame = 1.7},
                .frames = {.number = 1500, .divided_by = {"every"}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.sens", ScanSens, "Posed frames of ScanNet's own recordings, scene….sens")
FRESCO_LIBRARY("zlib", ZLIB_VERSION)
