#include "replica_scene.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/recordings/layout.h>

#include <fmt/format.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

class ReplicaLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"results", "traj.txt"}}; }

  private:
    Recording list(fresco::RunContext& run) override
    {
        const auto results = path() / "results";
        auto views = numbered_views({results, "frame", {".jpg", ".png"}}, {results, "depth", {".png"}}, {}, run);
        const auto scene = fs::weakly_canonical(path());
        const auto beside = scene.parent_path();
        const auto parameters = first_file({path() / "cam_params.json", beside / "cam_params.json"}, "the scene's camera", run);
        const auto camera = replica::parse_camera(fresco::read_text_file(parameters), parameters.string());
        trajectory_ = replica::parse_trajectory(recorded_text(trajectory_file(), run), trajectory_file().string());
        for (auto& view : views)
        {
            view.sequence = "results";
            view.camera = camera.intrinsics;
            view.depth_unit_m = camera.depth_unit_m;
        }
        return {.views = std::move(views),
                .files = "results/frameN.jpg (or .png) and results/depthN.png",
                .meshes = {path() / "mesh.ply", beside / (scene.filename().string() + "_mesh.ply")}};
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

FRESCO_COMPONENT("layout.replica", ReplicaLayout, fresco::recordings::Layout, "Replica scenes rendered in NICE-SLAM's layout")
