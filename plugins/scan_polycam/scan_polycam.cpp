#include "keyframes.h"

#include <fresco/files_io.h>
#include <fresco/stage.h>

namespace
{

class ScanPolycam final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the raw data export, with keyframes in it"};
    fresco::Option<std::string> poses{
        this, "poses", "corrected", fresco::one_of({"corrected", "recorded"}),
        "corrected: if the export has them, else recorded (with a warning); recorded: as tracked by ARKit"};
    fresco::Option<std::string> world{this, "world", "recorded", fresco::one_of({"recorded", "mesh"}),
                                      "recorded: ARKit's, y up; mesh: that of raw.glb, by mesh_info.json"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th keyframe"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The keyframes, by time"};

    void run(fresco::RunContext& run) override
    {
        const auto folders = polycam::keyframe_folders(path->path, *poses == "recorded");
        for (const char* name : {"corrected_cameras", "corrected_images"})
            run.reads_folder(path->path / "keyframes", name);
        run.reads_folder(folders.cameras, "*.json");
        auto views = polycam::list_keyframes(path->path, folders);
        fresco::recordings::keep_every(views, *every);
        fresco::RigidTransform mesh_from_world;
        if (*world == "mesh")
        {
            const auto file = path->path / "mesh_info.json";
            run.reads_file(file);
            mesh_from_world = polycam::parse_alignment(fresco::read_text_file(file), file.string());
        }
        for (auto& view : views)
        {
            const std::filesystem::path file = view.source;
            run.reads_file(file);
            polycam::parse_camera(fresco::read_text_file(file), file, view);
            view.world_from_camera = mesh_from_world * view.world_from_camera;
        }
        frames = fresco::recordings::registered_frames(views, *images, frames.folder().path, run);
        for (const auto& view : views)
        {
            run.reads_file(view.color);
            run.reads_file(view.depth);
        }
        if (!folders.corrected && *poses == "corrected")
            run.warning(
                "the export has no corrected cameras and images: poses as ARKit tracked them are taken, and the pictures' "
                "distortion stays; frames.align mends poses");
        run.report("frames", views.size());
        run.report("corrected", folders.corrected);
        run.message(std::to_string(views.size()) + " keyframes");
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.01},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 50},
                .disk_mb = {.fixed = 0.1},
                .frames = {.files = "path", .pattern = "keyframes/cameras/*.json", .divided_by = {"every"}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.polycam", ScanPolycam, "Keyframes of Polycam's raw data export, with LiDAR depth")
