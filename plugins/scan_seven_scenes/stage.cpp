#include "calibration.h"
#include "sequences.h"

#include <fresco/recordings/recording_stage.h>

#include <fmt/format.h>

namespace
{

using namespace fresco::recordings;

class ScanSevenScenes final : public RecordingStage
{
  public:
    ScanSevenScenes()
        : RecordingStage({.path = "Folder of the scan",
                          .frames = "The recorded views, each with a color and a depth camera",
                          .every = "Use every n-th frame of each sequence",
                          .folder = fresco::folder_with({"seq-*"})})
    {
    }

  private:
    RecordedMesh mesh{this, "Mesh in the poses' world; empty: mesh.ply in path", "The scanned surface"};
    fresco::Option<std::vector<int>> sequences{this, "sequences", std::vector<int>{}, fresco::range(0, 999'999),
                                               "Numbers of the sequences to read; empty: all"};
    fresco::Option<std::vector<double>> color_k{
        this, "color_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the color camera in pixels; empty: color-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> depth_k{
        this, "depth_intrinsics", std::vector<double>{},
        "fx, fy, cx, cy of the depth camera in pixels; empty: depth-intrinsics.txt in path"};
    fresco::Option<std::vector<double>> color_from_depth{
        this, "color_from_depth", std::vector<double>{},
        "4x4 matrix M, X_color = M X_depth in meters: 16 numbers, row by row; empty: color_from_depth.txt in path"};
    PixelCenterOption pixel_center{this, "half"};
    fresco::Option<double> depth_unit_m = depth_unit_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto folders = seven_scenes::list_sequences(path(), *sequences, run);
        Recording recording{.files = "seq-N/frame-N.color.png (or .jpg), .depth.png and .pose.txt",
                            .note = fmt::format(" of {} sequences", folders.size()),
                            .every_of_sequence = true};
        for (const auto& folder : folders)
            for (auto& view : numbered_views({folder, "frame-", {".color.png", ".color.jpg", ".color.jpeg"}},
                                             {folder, "frame-", {".depth.png"}}, {folder, "frame-", {".pose.txt"}}, run))
            {
                view.sequence = folder.filename().string();
                view.depth_unit_m = *depth_unit_m;
                recording.views.push_back(std::move(view));
            }
        calibration_ = seven_scenes::read_calibration(
            path(), {.color_intrinsics = *color_k, .depth_intrinsics = *depth_k, .color_from_depth = *color_from_depth}, run);
        mesh.read({path() / "mesh.ply"}, run);
        run.report("sequences", folders.size());
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        if (cameras_.color.width == 0)
            cameras_ = {seven_scenes::calibrated(calibration_.color, *pixel_center, codec().header(view.color), view.color),
                        seven_scenes::calibrated(calibration_.depth, *pixel_center, codec().header(view.depth), view.depth),
                        calibration_.color_from_depth.inverse()};
        view.source = view.pose.string();
        cameras_.place(view, fresco::recordings::read_rigid_transform(view.pose));
        return true;
    }

    fresco::Cost cost() const override
    {
        return {
            .seconds = {.fixed = 0.1, .per = {{fresco::count::frames, 0.001}, {fresco::count::faces, 5e-7}}},
            .memory_mb = {.fixed = 20, .per = {{fresco::count::faces, 1e-4}}},
            .disk_mb = {.per = {{fresco::count::faces, 2.1e-5}}},
            .makes = {{fresco::count::frames, {.files = "path", .pattern = "seq-*/frame-*.pose.txt", .divided_by = {"every"}}},
                      {fresco::count::faces, {.files = "path", .pattern = "mesh.ply", .bytes_each = 21}}}};
    }

    seven_scenes::Calibration calibration_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_STAGE("scan.seven_scenes", ScanSevenScenes, "Posed frames and mesh in the layout of 7-Scenes")
