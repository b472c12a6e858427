#include "tum.h"

#include <fresco/recordings/layout.h>
#include <fresco/recordings/listed_files.h>
#include <fresco/value.h>

#include <fmt/format.h>
#include <set>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

/// 5000 steps a meter.
constexpr double depth_unit_m = 0.0002;

class TumLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"rgb.txt", "depth.txt", "groundtruth.txt"}}; }

  private:
    fresco::Option<std::string> camera{this, "camera", "auto",
                                       fresco::one_of({"auto", "freiburg1", "freiburg2", "freiburg3", "ros_default"}),
                                       "Camera whose intrinsics and distortion to use; auto: from the folder's name"};
    fresco::Option<std::vector<double>> intrinsics{
        this, "intrinsics", std::vector<double>{},
        "fx, fy, cx, cy in pixels, first pixel's center at (0, 0); overrides camera and its distortion"};
    fresco::Option<std::vector<double>> distortion{
        this, "distortion", std::vector<double>{},
        "k1, k2, p1, p2, k3 as in OpenCV; overrides camera, with or without intrinsics"};
    fresco::Option<double> max_gap_s{this, "max_gap_s", 0.02, fresco::range(0, 10),
                                     "Maximum time between a color picture and its depth picture or pose"};

    Recording list(fresco::RunContext& run) override
    {
        camera_ = tum::recording_camera(*camera, *intrinsics, *distortion, path());
        const auto parsed = [&](const char* name, const auto& parse)
        {
            const auto file = path() / name;
            return parse(recorded_text(file, run), file.string());
        };
        const auto color = parsed("rgb.txt", tum::parse_pictures), depth = parsed("depth.txt", tum::parse_pictures);
        auto found = tum::associate(color, depth, parsed("groundtruth.txt", tum::parse_poses), *max_gap_s, path());
        for (auto& view : found.views)
            view.source += " with " + camera_.source;
        if (const auto gaps = tum::gaps_text(found); !gaps.empty())
            run.warning(fmt::format("{} color pictures have no depth picture and {} no pose within max_gap_s ({} s): {}; set "
                                    "max_gap_s to use more of them",
                                    found.without_depth, found.without_pose, fresco::to_json(*max_gap_s), gaps));
        warn_of_unlisted(color, run);
        run.report("without_depth", found.without_depth);
        run.report("without_pose", found.without_pose);
        run.report("camera", camera_.source);
        return {.views = std::move(found.views),
                .note = fmt::format("; left out {} without depth and {} without pose at their time", found.without_depth,
                                    found.without_pose)};
    }

    /// Names a picture beside the listed ones that the list lacks.
    void warn_of_unlisted(const std::vector<tum::StampedPicture>& color, fresco::RunContext& run) const
    {
        std::set<fs::path> listed;
        for (const auto& picture : color)
            listed.insert((path() / picture.name).lexically_normal());
        const auto folder = listed.begin()->parent_path();
        looks_for(folder / "*", run);
        std::set<fs::path> unlisted;
        std::error_code missing;
        for (const auto& entry : fs::directory_iterator(folder, missing))
            if (entry.path().extension() == listed.begin()->extension() && !is_system_file(entry.path()) &&
                !listed.contains(entry.path().lexically_normal()))
                unlisted.insert(entry.path());
        if (!unlisted.empty())
            run.warning(fmt::format("rgb.txt does not list {} of the pictures in its folder, first {}; they are not used",
                                    unlisted.size(), unlisted.begin()->string()));
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        if (camera_.intrinsics.width == 0)
        {
            const auto size = codec().header(view.color);
            camera_.intrinsics.width = size.width;
            camera_.intrinsics.height = size.height;
        }
        view.camera = camera_.intrinsics;
        view.lens = camera_.lens;
        view.depth_unit_m = depth_unit_m;
        return true;
    }

    tum::RecordingCamera camera_;
};

}  // namespace

FRESCO_COMPONENT("layout.tum", TumLayout, fresco::recordings::Layout,
                 "The TUM RGB-D data set: lists of pictures and poses by time")
