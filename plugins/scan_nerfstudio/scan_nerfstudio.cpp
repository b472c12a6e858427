#include "transforms.h"

#include <fresco/component.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>

namespace
{

class ScanNerfstudio final : public fresco::Stage
{
    fresco::Option<fresco::InputFolder> path{this, "path", fresco::required,
                                             "Folder of the recording, with transforms.json in it"};
    fresco::Option<fresco::InputFile> transforms{this, "transforms", fresco::InputFile{},
                                                 "Cameras and poses; empty: transforms.json in path"};
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder that file_path is relative to; empty: that of the transforms"};
    fresco::Option<std::string> world{this, "world", "saved", fresco::one_of({"saved", "original"}),
                                      "saved: the file's world; original: with applied_transform and applied_scale undone"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the poses in that world"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.0, fresco::range(0, 1),
                                        "Meters per step of the depth pictures; 0: what the file says, else a millimeter"};
    fresco::Option<int> every{this, "every", 1, fresco::range(1, 1'000'000), "Take every n-th frame"};
    fresco::Slot<fresco::ImageIo> images{this, "images", "image.opencv", "Reader and writer of pictures"};

    fresco::Output<fresco::Frames> frames{this, "frames", "The recorded views, by name"};

    void run(fresco::RunContext& run) override
    {
        const auto file = transforms->empty() ? path->path / "transforms.json" : transforms->path;
        run.reads_file(file);
        auto read = nerfstudio::parse_transforms(fresco::read_text_file(file), file,
                                                 {*world == "original" ? nerfstudio::World::original : nerfstudio::World::saved,
                                                  *unit_m, *depth_unit_m, pictures->path});
        fresco::recordings::keep_every(read.views, *every);
        if (read.has_masks)
            run.warning("the frames have masks (mask_path), which are not used");
        frames = fresco::recordings::registered_frames(read.views, *images, frames.folder().path, run);
        std::size_t with_lens = 0;
        for (const auto& view : read.views)
        {
            run.reads_file(view.color);
            if (!view.depth.empty())
                run.reads_file(view.depth);
            with_lens += view.lens.distorts() ? 1 : 0;
        }
        run.report("frames", read.views.size());
        run.report("undistorted", with_lens);
        run.report("has_depth", read.with_depth > 0);
        run.message(std::to_string(read.views.size()) + " frames" + (read.with_depth > 0 ? "" : " without depth") +
                    (with_lens > 0 ? ", " + std::to_string(with_lens) + " undistorted" : ""));
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per_frame = 0.05},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 50, .per_core = 60},
                .frames = {.files = "path", .pattern = "images/*", .divided_by = {"every"}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.nerfstudio", ScanNerfstudio, "Posed frames of nerfstudio's transforms.json, as Polycam and Record3D give it")
