#include "transforms.h"

#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/layout.h>

#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

class NerfstudioLayout final : public Layout
{
  public:
    fresco::Marks marks() const override
    {
        return {.contains = {"transforms.json|nerfstudio/transforms.json"},
                .formats = {fresco::json_format()},
                .before = {"layout.colmap"}};
    }

  private:
    fresco::Option<fresco::InputFolder> pictures{this, "pictures", fresco::InputFolder{},
                                                 "Folder that file_path is relative to; empty: that of the file"};
    fresco::Option<fresco::InputFolder> masks{this, "masks", fresco::InputFolder{},
                                              "Folder that mask_path is relative to; empty: that of the file"};
    fresco::Option<std::string> split{this, "split", "all", fresco::one_of({"all", "train", "val", "test"}),
                                      "all: the file's frames; else those of its train_filenames, val_filenames or "
                                      "test_filenames, or of ScanNet++'s test_frames"};
    fresco::Option<std::string> world{this, "world", "saved", fresco::one_of({"saved", "original"}),
                                      "saved: the file's world; original: with applied_transform and applied_scale undone"};

    Recording list(fresco::RunContext& run) override
    {
        const auto scannetpp = path() / "nerfstudio/transforms.json";
        const auto file =
            first_file(fs::is_directory(path()) ? std::vector{path() / "transforms.json", scannetpp} : std::vector{path()},
                       "the file of cameras and poses", run);
        nerfstudio::Reading reading{
            .original_world = *world == "original", .pictures = pictures->path, .masks = masks->path, .split = *split};
        if (file == scannetpp && pictures->empty())
            reading.pictures = path() / "resized_images";
        if (file == scannetpp && masks->empty())
            reading.masks = path() / "resized_anon_masks";
        reading.size_of = [this](const fs::path& picture) { return codec().header(picture); };
        return {.views = nerfstudio::parse_transforms(fresco::read_text_file(file), file, reading, run)};
    }

    bool locate(RecordedView& view, fresco::RunContext& run) override
    {
        if (!std::isfinite(view.world_from_camera.translation.x))
            return false;
        if (view.color.extension() == ".npy")
            return true;
        const auto size = codec().header(view.color);
        const auto& k = view.camera;
        const auto product = [](int a, int b) { return std::int64_t{a} * b; };
        // Pictures are often made smaller after the file was written.
        if (!view.is_panorama && size.width != k.width && product(size.width, k.height) == product(size.height, k.width))
        {
            if (!std::exchange(has_told_size_, true))
                run.message(
                    fmt::format("pictures have another size than their camera, such as {}: {}x{}, and the camera {}x{}; its "
                                "intrinsics are scaled",
                                view.color.string(), size.width, size.height, k.width, k.height));
            view.camera = k.scaled_to(size.width, size.height);
        }
        return true;
    }

    bool has_told_size_ = false;
};

}  // namespace

FRESCO_COMPONENT("layout.nerfstudio", NerfstudioLayout, fresco::recordings::Layout,
                 "nerfstudio's transforms.json, as Polycam and Record3D write it")
