#include "keyframes.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>

#include <algorithm>
#include <fmt/format.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

class PolycamLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"keyframes/cameras|keyframes/corrected_cameras"}}; }

  private:
    fresco::Option<std::string> world{this, "world", "recorded", fresco::one_of({"recorded", "mesh"}),
                                      "recorded: ARKit's, y up; mesh: that of raw.glb, by mesh_info.json"};

    Recording list(fresco::RunContext& run) override
    {
        const auto cameras = camera_folder(run);
        const bool is_corrected = cameras.filename() != "cameras";
        const auto pictures = cameras.parent_path() / (is_corrected ? "corrected_images" : "images");
        Recording recording{.files = "keyframes/" + cameras.filename().string() + "/N.json, " + pictures.filename().string() +
                                     "/N.jpg and depth/N.png"};
        if (*world == "mesh")
        {
            const auto file = path() / "mesh_info.json";
            mesh_from_world_ = polycam::parse_alignment(recorded_text(file, run), file.string());
        }
        looks_for(cameras / "*.json", run);
        looks_for(path() / "keyframes/depth/*.png", run);
        for (const auto& entry : fs::directory_iterator(cameras))
        {
            if (entry.path().extension() != ".json" || is_system_file(entry.path()))
                continue;
            const auto stem = entry.path().stem().string();
            RecordedView view;
            name_by_picture(view, fs::path("keyframes") / stem);
            view.pose = entry.path();
            view.color = pictures / (stem + ".jpg");
            view.depth = path() / "keyframes/depth" / (stem + ".png");
            recording.views.push_back(std::move(view));
        }
        forget_missing_depth(recording.views);
        // Polycam corrects no keyframe that it cannot place.
        const auto without_camera = std::max(count_pictures(pictures, run), count_pictures(path() / "keyframes/images", run)) -
                                    std::ssize(recording.views);
        if (without_camera > 0)
            recording.note = fmt::format("; left out {} without a {}camera", without_camera, is_corrected ? "corrected " : "");
        order_by_name(recording.views);
        run.report("corrected", is_corrected);
        return recording;
    }

    static std::ptrdiff_t count_pictures(const fs::path& folder, fresco::RunContext& run)
    {
        looks_for(folder / "*.jpg", run);
        std::error_code missing;
        return std::ranges::count_if(fs::directory_iterator(folder, missing), [](const auto& entry)
                                     { return entry.path().extension() == ".jpg" && !is_system_file(entry.path()); });
    }

    /// The corrected ones where both of their folders are there, else those as recorded.
    fs::path camera_folder(fresco::RunContext& run) const
    {
        const auto keyframes = path() / "keyframes";
        for (const char* name : {"corrected_cameras", "corrected_images"})
            looks_for(keyframes / name, run);
        if (fs::is_directory(keyframes / "corrected_cameras") && fs::is_directory(keyframes / "corrected_images"))
            return keyframes / "corrected_cameras";
        run.warning("the export has no corrected cameras and images: using the poses ARKit tracked and distorted pictures; "
                    "frames.align can correct the poses");
        for (const char* name : {"cameras", "images"})
            if (!fs::is_directory(keyframes / name))
                throw fresco::MissingInput((keyframes / name).string() +
                                           ": no such folder; expected Polycam's raw data export, with "
                                           "keyframes/cameras, keyframes/images and keyframes/depth in it");
        return keyframes / "cameras";
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        polycam::parse_camera(fresco::read_text_file(view.pose), view);
        if (view.camera.width == 0 || view.camera.height == 0)
        {
            const auto size = codec().header(view.color);
            view.camera.width = size.width;
            view.camera.height = size.height;
        }
        view.world_from_camera = mesh_from_world_ * view.world_from_camera;
        return true;
    }

    fresco::RigidTransform mesh_from_world_;
};

}  // namespace

FRESCO_COMPONENT("layout.polycam", PolycamLayout, fresco::recordings::Layout, "Polycam's raw data export, with LiDAR depth")
