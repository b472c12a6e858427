#include "transforms.h"

#include <fresco/files_io.h>
#include <fresco/recordings/recording_stage.h>

namespace
{

using namespace fresco::recordings;

class ScanNerfstudio final : public RecordingStage
{
  public:
    ScanNerfstudio()
        : RecordingStage({.path = "Folder of the recording",
                          .frames = "The recorded views, by name",
                          .folder = fresco::folder_with({"transforms.json|nerfstudio/transforms.json"}, "transforms")})
    {
    }

  private:
    fresco::Option<fresco::InputFile> transforms{this, "transforms", fresco::InputFile{},
                                                 fresco::formats({fresco::json_format()}),
                                                 "Cameras and poses; empty: transforms.json in path"};
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder that file_path is relative to; empty: the folder of transforms"};
    fresco::Option<fresco::InputFolder> masks{this, "masks", fresco::InputFolder{},
                                              "Folder that mask_path is relative to; empty: the folder of transforms"};
    fresco::Option<std::string> split{this, "split", "all", fresco::one_of({"all", "train", "val", "test"}),
                                      "all: the file's frames; else those of its train_filenames, val_filenames or "
                                      "test_filenames, or of ScanNet++'s test_frames"};
    fresco::Option<std::string> world{this, "world", "saved", fresco::one_of({"saved", "original"}),
                                      "saved: the file's world; original: with applied_transform and applied_scale undone"};
    fresco::Option<double> unit_m{this, "unit_m", 1.0, fresco::range(1e-6, 1e6), "Meters per unit of the poses in that world"};
    fresco::Option<double> depth_unit_m{this, "depth_unit_m", 0.0, fresco::range(0, 1),
                                        "Meters per step of the depth pictures; 0: as in the file, or else a millimeter"};

    Recording list(fresco::RunContext& run) override
    {
        const auto scannetpp = path() / "nerfstudio/transforms.json";
        const auto file =
            first_file(*transforms, {path() / "transforms.json", scannetpp}, "the file of cameras and poses", "transforms", run);
        nerfstudio::Reading reading{.world = *world == "original" ? nerfstudio::World::original : nerfstudio::World::saved,
                                    .unit_m = *unit_m,
                                    .depth_unit_m = *depth_unit_m,
                                    .pictures = pictures->path,
                                    .masks = masks->path,
                                    .split = *split};
        if (file == scannetpp && pictures->empty())
            reading.pictures = path() / "resized_images";
        if (file == scannetpp && masks->empty())
            reading.masks = path() / "resized_anon_masks";
        return {.views = nerfstudio::parse_transforms(fresco::read_text_file(file), file, reading)};
    }
};

}  // namespace

FRESCO_STAGE("scan.nerfstudio", ScanNerfstudio, "Posed frames of nerfstudio's transforms.json, as Polycam and Record3D write it")
