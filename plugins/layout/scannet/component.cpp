#include "scene_calibration.h"

#include <fresco/error.h>
#include <fresco/mesh.h>
#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/run_context.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

/// The text file of the scene's properties, `path`/<scene>.txt: the one named like the folder, else the only .txt file. Empty if
/// there is none.
fs::path find_properties(const fs::path& path, fresco::RunContext& run)
{
    const auto named = path / (fs::weakly_canonical(path).filename().string() + ".txt");
    if (fs::exists(named))
        return named;
    run.reads_folder(path, "*.txt");
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path))
        if (entry.is_regular_file() && entry.path().extension() == ".txt" && !is_system_file(entry.path()))
            files.push_back(entry.path());
    return files.size() == 1 ? files[0] : fs::path{};
}

class ScannetLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"color", "depth", "pose"}}; }

  private:
    fresco::Choice<PixelCenter> pixel_center = pixel_center_option(this, PixelCenter::integer);

    Recording list(fresco::RunContext& run) override
    {
        auto views = numbered_views({path() / "color", "", {".jpg", ".png"}}, {path() / "depth", "", {".png"}},
                                    {path() / "pose", "", {".txt"}}, run);
        for (auto& view : views)
        {
            view.sequence = "scene";
            view.name = std::to_string(view.number);
        }
        calibration_ = scannet::read_scene_calibration(path(), find_properties(path(), run), run);
        return {.views = std::move(views),
                .files = "color/N.jpg (or .png), depth/N.png and pose/N.txt",
                .meshes = {path() / "*_vh_clean.ply", path() / "*_vh_clean_2.ply"}};
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        view.source = view.pose.string();
        if (cameras_.color.width == 0)
            cameras_ = {intrinsics_for(calibration_.color, *pixel_center, codec().header(view.color), view.color),
                        intrinsics_for(calibration_.depth, *pixel_center, codec().header(view.depth), view.depth),
                        calibration_.depth_from_color};
        const auto pose = tracked_pose(read_matrix_text(view.pose, 4, 4), view.source);
        if (!pose)
            return false;
        cameras_.place(view, *pose);
        return true;
    }

    scannet::SceneCalibration calibration_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_COMPONENT("layout.scannet", ScannetLayout, fresco::recordings::Layout, "Exported ScanNet scenes")
