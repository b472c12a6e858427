#include "model_views.h"

#include <fresco/recordings/recording_stage.h>

namespace
{

using namespace fresco::recordings;

class ScanColmap final : public RecordingStage
{
  public:
    ScanColmap()
        : RecordingStage({.path = "Folder of the project, with the reconstruction in sparse/0 or sparse",
                          .frames = "The registered pictures, by name",
                          .every = "Use every n-th picture"})
    {
    }

  private:
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder of the pictures; empty: images in path"};
    fresco::Option<fresco::InputFolder> depth{this, "depth", fresco::InputFolder{},
                                              "Folder of depth pictures, named like the pictures, .png; empty: none"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the reconstruction"};
    fresco::Option<double> depth_unit_m = depth_unit_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto files = colmap::find_model(path(), run);
        const auto cameras = colmap::read_cameras(files.cameras);
        run.report("cameras", cameras.size());
        return {.views = colmap::model_views(cameras, colmap::read_images(files.images), files.images,
                                             {.pictures = pictures->empty() ? path() / "images" : pictures->path,
                                              .depth = depth->path,
                                              .unit_m = *unit_m,
                                              .depth_unit_m = *depth_unit_m})};
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
