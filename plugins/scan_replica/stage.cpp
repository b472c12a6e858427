#include "replica_scene.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/recordings/recording_stage.h>

#include <fmt/format.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

class ScanReplica final : public RecordingStage
{
  public:
    ScanReplica()
        : RecordingStage({.path = "Folder of the scene",
                          .frames = "The rendered views",
                          .folder = fresco::folder_with({"results", "traj.txt"})})
    {
    }

  private:
    RecordedMesh mesh{this, "Mesh in the poses' world; empty: mesh.ply in path, or <scene>_mesh.ply beside it",
                      "The scene's surface"};
    fresco::Option<fresco::InputFile> camera_file{this, "camera", fresco::InputFile{}, fresco::formats({fresco::json_format()}),
                                                  "Camera; empty: cam_params.json in path or beside it"};

    Recording list(fresco::RunContext& run) override
    {
        const auto results = path() / "results";
        auto views = numbered_views({results, "frame", {".jpg", ".png"}}, {results, "depth", {".png"}}, {}, run);
        const auto scene = fs::weakly_canonical(path());
        const auto beside = scene.parent_path();
        mesh.read({path() / "mesh.ply", beside / (scene.filename().string() + "_mesh.ply")}, run);
        const auto parameters = first_file(*camera_file, {path() / "cam_params.json", beside / "cam_params.json"},
                                           "the scene's camera", "camera", run);
        const auto camera = replica::parse_camera(fresco::read_text_file(parameters), parameters.string());
        trajectory_ = replica::parse_trajectory(recorded_text(trajectory_file(), run), trajectory_file().string());
        for (auto& view : views)
        {
            view.sequence = "results";
            view.camera = camera.intrinsics;
            view.depth_unit_m = camera.depth_unit_m;
        }
        return {.views = std::move(views), .files = "results/frameN.jpg (or .png) and results/depthN.png"};
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const auto line = static_cast<std::size_t>(view.number);
        if (line >= trajectory_.size())
            throw fresco::Error(fmt::format("{}: {} poses, but frame {} has pictures; expected one line per frame from frame 0 "
                                            "on: the file is truncated or belongs to another scene",
                                            trajectory_file().string(), trajectory_.size(), view.number));
        view.world_from_camera = trajectory_[line];
        view.source = fmt::format("{}:{}", trajectory_file().string(), line + 1);
        return true;
    }

    fs::path trajectory_file() const { return path() / "traj.txt"; }

    std::vector<fresco::RigidTransform> trajectory_;
};

}  // namespace

FRESCO_STAGE("scan.replica", ScanReplica, "Rendered frames and mesh of a Replica scene, in NICE-SLAM's layout")
