#include <fresco/recordings/layout.h>
#include <fresco/stage.h>

namespace
{

using namespace fresco;
using namespace fresco::recordings;

class ScanRecording final : public Stage
{
    Option<InputPath> path{this, "path", required, "The recording: a folder, or a single file"};
    Slot<Layout> layout{this, "layout", ByMarks{"path"}, "Recorder or data set that names and writes its files so"};
    Option<int> every{this, "every", 1, range(1, 1'000'000), "Use every n-th view, of each sequence where there are several"};
    Option<InputFile> mesh_file{this, "mesh", InputFile{}, formats({ply_format(), obj_format()}),
                                "Mesh in the poses' world, in meters; empty: the recording's own, if it has one"};
    Option<double> unit_m{this, "unit_m", 1.0, range(1e-6, 1e6), "Meters per unit of the poses"};
    Option<double> depth_unit_m{this, "depth_unit_m", 0.0, range(0, 1),
                                "Meters per step of the depth pictures; 0: as the layout has it, usually a millimeter"};
    Slot<ImageIo> images{this, "Reads and writes pictures"};
    Output<Frames> frames{this, "frames", "The recorded views"};
    Output<Mesh> mesh{this, "mesh", optional, "The recorded surface"};

    void run(RunContext& run) override
    {
        auto recording = read_recording(
            *layout, {.path = path->path, .every = *every, .mesh = *mesh_file, .unit_m = *unit_m, .depth_unit_m = *depth_unit_m},
            *images, frames.folder().path, run);
        frames = std::move(recording.frames);
        if (recording.mesh)
            mesh = std::move(*recording.mesh);
    }
};

}  // namespace

FRESCO_STAGE("scan.recording", ScanRecording, "Posed frames of a recording, and its mesh, in any layout that is known")
