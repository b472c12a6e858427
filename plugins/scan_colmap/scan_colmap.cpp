#include "model_views.h"

#include <fresco/component.h>
#include <fresco/stage.h>

namespace
{

namespace fs = std::filesystem;

class ScanColmap final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the project, with the reconstruction in it, in sparse/0 or in sparse"};
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder of the pictures; empty: images in path"};
    fresco::Option<fresco::InputFolder> depth{this, "depth", fresco::InputFolder{},
                                              "Folder of depth pictures, named like the pictures, .png; empty: none"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the reconstruction"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.001, fresco::range(1e-6, 1.0),
                                        "Meters per step of the depth pictures"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th picture"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The pictures that were placed, by name"};

    void run(fresco::RunContext& run) override
    {
        const auto folders = colmap::model_folders(path->path);
        const auto files = colmap::find_model(folders);
        run.reads_folder(path->path, "sparse");
        run.reads_folder(path->path, "colmap");
        for (const auto& folder : folders)
            if (fs::is_directory(folder))
                for (const char* names : {"0", "cameras.*", "images.*"})
                    run.reads_folder(folder, names);
        run.reads_file(files.cameras);
        run.reads_file(files.images);

        const auto cameras = colmap::read_cameras(files.cameras);
        auto views = colmap::model_views(
            cameras, colmap::read_images(files.images), files.images,
            {pictures->empty() ? path->path / "images" : pictures->path, depth->path, *unit_m, *depth_unit_m});
        fresco::recordings::keep_every(views, *every);
        frames = fresco::recordings::registered_frames(views, *images, frames.folder().path, run);
        std::size_t with_lens = 0;
        for (const auto& view : views)
        {
            run.reads_file(view.color);
            if (!view.depth.empty())
                run.reads_file(view.depth);
            with_lens += view.lens.distorts() ? 1 : 0;
        }
        run.report("frames", views.size());
        run.report("cameras", cameras.size());
        run.report("undistorted", with_lens);
        run.report("has_depth", !depth->empty());
        run.message(std::to_string(views.size()) + " frames" + (depth->empty() ? " without depth" : "") +
                    (with_lens > 0 ? ", " + std::to_string(with_lens) + " undistorted" : ""));
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.05},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 50, .per_core = 60, .per_frame = 0.3},
                .frames = {.files = "path", .pattern = "images/*", .divided_by = {"every"}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.colmap", ScanColmap, "Posed frames of a COLMAP reconstruction, text or binary")
