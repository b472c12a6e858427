#include "house.h"

#include <fresco/error.h>
#include <fresco/recordings/layout.h>

#include <fmt/format.h>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

/// 4 000 steps a meter.
constexpr double depth_unit_m = 0.00025;

class Matterport3dLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"undistorted_camera_parameters/*.conf"}}; }

  private:
    fresco::Option<int> region{this, "region", -1, fresco::range(-1, 100'000),
                               "Only this room: its mesh and the pictures taken in it; -1: the whole house"};

    Recording list(fresco::RunContext& run) override
    {
        looks_for(path() / "undistorted_camera_parameters/*.conf", run);
        const auto camera_file = matterport3d::camera_file(path());
        const std::string house = camera_file.stem().string();
        cameras_ = matterport3d::parse_cameras(recorded_text(camera_file, run), camera_file.string());
        const auto segmentations = path() / "house_segmentations";
        const auto house_file = segmentations / (house + ".house");
        std::map<std::string, int> regions;
        if (*region >= 0)
            regions = matterport3d::parse_regions(recorded_text(house_file, run), house_file.string());
        Recording recording{.note = fmt::format(" of {}'s {}", house, cameras_.views.size())};
        for (std::size_t i = 0; i < cameras_.views.size(); ++i)
        {
            const auto& listed = cameras_.views[i];
            const auto at = regions.find(listed.panorama);
            if (*region >= 0 && at == regions.end())
                throw fresco::Error(house_file.string() + ": panorama " + listed.panorama + " of " + listed.source +
                                    " is missing; use the files of one house");
            if (*region >= 0 && at->second != *region)
                continue;
            RecordedView view;
            name_by_picture(view, fs::path(house) / listed.color);
            view.number = static_cast<long>(i);
            view.color = path() / cameras_.color_folder / listed.color;
            view.depth = path() / cameras_.depth_folder / listed.depth;
            view.world_from_camera = listed.world_from_camera;
            view.depth_unit_m = depth_unit_m;
            view.source = listed.source;
            recording.views.push_back(std::move(view));
        }
        if (recording.views.empty())
            throw fresco::Error(fmt::format("{}: no picture was taken in region {}; use a region from a P line of that file",
                                            house_file.string(), *region));
        if (*region >= 0)
            recording.meshes = {path() / "region_segmentations" / fmt::format("region{}.ply", *region)};
        else
            recording.meshes = {segmentations / (house + ".ply"), path() / "poisson_meshes" / (house + ".ply")};
        run.report("house", house);
        run.report("house_frames", cameras_.views.size());
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        if (size_.width == 0)
            size_ = codec().header(view.color);
        view.camera = matterport3d::camera_of(cameras_.views[static_cast<std::size_t>(view.number)], size_.width, size_.height);
        return true;
    }

    matterport3d::HouseCameras cameras_;
    fresco::ImageHeader size_;  ///< Size of the first chosen picture, and so of all.
};

}  // namespace

FRESCO_COMPONENT("layout.matterport3d", Matterport3dLayout, fresco::recordings::Layout,
                 "Undistorted pictures of a Matterport3D house, or of one of its rooms")
