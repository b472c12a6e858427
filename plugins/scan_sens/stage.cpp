#include "sens_pictures.h"

#include <fresco/recordings/recording_stage.h>

#include <fmt/format.h>
#include <optional>
#include <zlib.h>

namespace
{

using namespace fresco::recordings;

class ScanSens final : public RecordingStage
{
  public:
    ScanSens()
        : RecordingStage({.path = "The recording, scene….sens",
                          .frames = "The recorded views, each with a color and a depth camera",
                          .extensions = fresco::extensions({".sens"})})
    {
    }

  private:
    Recording list(fresco::RunContext& run) override
    {
        file_.emplace(path());
        index_ = sens::read_index(*file_);
        cameras_ = {
            intrinsics(index_.color, "the color camera"), intrinsics(index_.depth, "the depth camera"),
            fresco::recordings::rigid_transform(index_.depth.extrinsics, source("the depth camera's extrinsics")).inverse() *
                fresco::recordings::rigid_transform(index_.color.extrinsics, source("the color camera's extrinsics"))};
        Recording recording{.files = "a pose and two pictures", .note = fmt::format(", {} recorded", index_.frames.size())};
        for (std::size_t i = 0; i < index_.frames.size(); ++i)
        {
            RecordedView view;
            view.sequence = "scene";
            view.name = fmt::format("frame-{:06}", i);
            view.number = static_cast<long>(i);
            view.depth_unit_m = index_.depth_unit_m;
            view.source = source(fmt::format("byte {}, {}", index_.frames[i].color_offset, view.name));
            recording.views.push_back(std::move(view));
        }
        run.report("recorded", index_.frames.size());
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const auto pose = tracked_pose(frame_of(view).world_from_depth, view.source + ": the pose");
        if (pose)
            cameras_.place(view, *pose);
        return pose.has_value();
    }

    bool unpack(RecordedView& view, const std::filesystem::path& folder) const override
    {
        view.color = sens::write_color(*file_, index_, frame_of(view), codec(), folder, view.name);
        view.depth = sens::write_depth(*file_, index_, frame_of(view), codec(), folder, view.name);
        return true;
    }

    const sens::SensFrame& frame_of(const RecordedView& view) const
    {
        return index_.frames[static_cast<std::size_t>(view.number)];
    }
    std::string source(const std::string& what) const { return path().string() + ": " + what; }
    fresco::Intrinsics intrinsics(const sens::SensCamera& camera, const std::string& what) const
    {
        return intrinsics_for({camera.intrinsics, source(what)}, fresco::recordings::PixelCenter::integer,
                              {camera.width, camera.height}, path());
    }

    fresco::Cost cost() const override
    {
        return {.seconds = {.per_frame = 0.05},
                .parallel_share = 1,
                .memory_mb = {.fixed = 60, .per_core = 15},
                .disk_mb = {.per_frame = 1.7},
                .frames = {.number = 1500, .divided_by = {"every"}}};
    }

    std::optional<sens::SensFile> file_;
    sens::SensIndex index_;
    RecorderCameras cameras_;
};

}  // namespace

FRESCO_STAGE("scan.sens", ScanSens, "Posed frames of ScanNet's native recordings (.sens)")
FRESCO_LIBRARY("zlib", ZLIB_VERSION)
