#include "model.h"

#include <fresco/recordings/recording_stage.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

class ScanColmap final : public RecordingStage
{
  public:
    ScanColmap()
        : RecordingStage({.path = "Folder of the project",
                          .frames = "The registered pictures, by name",
                          .every = "Use every n-th picture",
                          .folder = fresco::folder_with(
                              {"cameras.*|sparse/0/cameras.*|sparse/cameras.*|colmap/sparse/0/cameras.*|colmap/cameras.*|"
                               "colmap_sparse/0/cameras.*|colmap_sparse/cameras.*"})})
    {
    }

  private:
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder of the pictures; empty: images, rgb or resized_images in path"};
    fresco::Option<fresco::InputFolder> depth{this, "depth", fresco::InputFolder{},
                                              "Folder of depth pictures, named like the pictures, .png; empty: none"};
    fresco::Option<fresco::InputFolder> masks{this, "masks", fresco::InputFolder{},
                                              "Folder of masks, black where to ignore the picture, named like it with .png added "
                                              "or in place of its ending; empty: none"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the reconstruction"};
    fresco::Option<double> depth_unit_m = depth_unit_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto files = colmap::find_model(path(), run);
        const auto cameras = colmap::read_cameras(files.cameras);
        run.report("cameras", cameras.size());
        if (!masks->empty())
            looks_for(masks->path / "*.png", run);
        return {.views = colmap::model_views(cameras, colmap::read_images(files.images), files.images,
                                             {.pictures = picture_folder(run),
                                              .depth = depth->path,
                                              .masks = masks->path,
                                              .unit_m = *unit_m,
                                              .depth_unit_m = *depth_unit_m})};
    }

    fs::path picture_folder(fresco::RunContext& run) const
    {
        if (!pictures->empty())
            return pictures->path;
        for (const char* name : {"images", "rgb", "resized_images"})
        {
            looks_for(path() / name, run);
            if (fs::is_directory(path() / name))
                return path() / name;
        }
        throw fresco::MissingInput(path().string() +
                                   ": there is no folder images (or rgb, resized_images); expected the "
                                   "reconstruction's pictures in it: put them there, or set option \"pictures\" "
                                   "to their folder");
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.fixed = 0.5, .per = {{fresco::count::frames, 0.05}}},
                .parallel_share = 0.9,
                .memory_mb = {.fixed = 50, .per_core = 60, .per = {{fresco::count::frames, 0.3}}},
                .makes = {{fresco::count::frames, {.files = "path", .pattern = "images/*", .divided_by = {"every"}}}}};
    }
};

}  // namespace

FRESCO_STAGE("scan.colmap", ScanColmap, "Posed frames of a COLMAP reconstruction, text or binary")
