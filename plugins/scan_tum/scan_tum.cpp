#include "tum_camera.h"
#include "tum_lists.h"

#include <fresco/component.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>

namespace
{

class ScanTum final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the recording, with rgb.txt, depth.txt and groundtruth.txt in it"};
    fresco::Option<std::string> camera{this, "camera", "auto",
                                       fresco::one_of({"auto", "freiburg1", "freiburg2", "freiburg3", "ros_default"}),
                                       "Whose intrinsics and lens; auto: by the folder's name"};
    fresco::Option<std::vector<double>> intrinsics{
        this, "intrinsics", std::vector<double>{},
        "fx, fy, cx, cy in pixels, first pixel's center at (0, 0); replaces the camera's, without its lens"};
    fresco::Option<std::vector<double>> distortion{
        this, "distortion", std::vector<double>{},
        "k1, k2, p1, p2, k3 as in OpenCV; replaces the camera's, also with intrinsics"};
    fresco::Option<double> max_gap_s{this, "max_gap_s", 0.02, fresco::range(0, 10),
                                     "How far apart in time a color picture may be from its depth picture and its pose"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.0002, fresco::range(1e-6, 1.0),
                                        "Meters per step of the depth pictures"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th view"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The views that have color, depth and pose"};

    void run(fresco::RunContext& run) override
    {
        const auto& folder = path->path;
        const auto read = [&](const char* name)
        {
            run.reads_file(folder / name);
            return fresco::read_text_file(folder / name);
        };
        const auto source = [&](const char* name) { return (folder / name).string(); };
        const auto with = tum::recording_camera(*camera, *intrinsics, *distortion, folder);
        auto found = tum::associate(tum::parse_pictures(read("rgb.txt"), source("rgb.txt")),
                                    tum::parse_pictures(read("depth.txt"), source("depth.txt")),
                                    tum::parse_poses(read("groundtruth.txt"), source("groundtruth.txt")), *max_gap_s, folder);
        fresco::recordings::keep_every(found.views, *every);
        set_cameras(found.views, with);
        frames = fresco::recordings::registered_frames(found.views, *images, frames.folder().path, run);
        for (const auto& view : found.views)
        {
            run.reads_file(view.color);
            run.reads_file(view.depth);
        }
        run.report("frames", found.views.size());
        run.report("without_depth", found.without_depth);
        run.report("without_pose", found.without_pose);
        run.report("camera", with.source);
        run.message(std::to_string(found.views.size()) + " frames; left out " + std::to_string(found.without_depth) +
                    " without depth and " + std::to_string(found.without_pose) + " without pose at their time");
    }

    void set_cameras(std::vector<fresco::recordings::RegisteredView>& views, const tum::RecordingCamera& with) const
    {
        auto k = with.intrinsics;
        if (k.width == 0)
        {
            const auto size = images->header(views.front().color);
            k.width = size.width;
            k.height = size.height;
        }
        for (auto& view : views)
        {
            view.camera = k;
            view.lens = with.lens;
            view.depth_unit_m = *depth_unit_m;
            view.source += " with " + with.source;
        }
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.03},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 50, .per_core = 20},
                .disk_mb = {.per_frame = 0.4},
                .frames = {.files = "path", .pattern = "rgb/*", .divided_by = {"every"}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.tum", ScanTum, "Posed frames in the layout of the TUM RGB-D data set")
