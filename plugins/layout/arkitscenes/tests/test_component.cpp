#include "catch.h"
#include "layout_checks.h"

#include <fmt/format.h>

namespace
{

using namespace fresco;
using namespace fresco::testing;

/// Axis times angle of a rotation of less than half a turn.
Vec3d turn_of(const Mat3& r)
{
    const auto q = quaternion_of(r);
    const Vec3d axis{q[1], q[2], q[3]};
    return length(axis) == 0 ? axis : axis * (2 * std::atan2(length(axis), q[0]) / length(axis));
}

/// The times in the names are 2 ms off those of the poses, but for the first picture's.
fs::path write_arkitscenes(const Frames& frames, const fs::path& folder, const ImageIo& images)
{
    std::string trajectory;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        const auto name = fmt::format("41069021_{:.3f}", 305.377 + 0.1 * static_cast<double>(i));
        copy_picture(frame.color_picture.path, folder / "lowres_wide" / (name + ".png"));
        copy_picture(frame.depth_picture.path, folder / "lowres_depth" / (name + ".png"));
        Raster8 confidence(16, 12, 3);
        std::ranges::fill(confidence.values, std::uint8_t{2});
        fs::create_directories(folder / "confidence");
        write_file(folder / "confidence" / (name + ".png"), images.encode_png(confidence));
        const auto& k = frame.color.intrinsics;
        fs::create_directories(folder / "lowres_wide_intrinsics");
        write_file(folder / "lowres_wide_intrinsics" / (name + ".pincam"),
                   fmt::format("{} {} {} {} {} {}", k.width, k.height, k.fx, k.fy, k.cx, k.cy));
        const auto camera_from_world = frame.color.world_from_camera.inverse();
        const auto turn = turn_of(camera_from_world.rotation);
        const auto& t = camera_from_world.translation;
        trajectory += fmt::format("{:.3f} {} {} {} {} {} {}\n", 305.377 + 0.1 * static_cast<double>(i) + (i > 0 ? 0.002 : 0),
                                  turn.x, turn.y, turn.z, t.x, t.y, t.z);
    }
    write_file(folder / "lowres_wide.traj", trajectory);
    write_mesh(folder / "41069021_3dod_mesh.ply");
    return folder;
}

const LayoutUnderTest layout{.type = "layout.arkitscenes", .write = write_arkitscenes};

}  // namespace

TEST_CASE("a video of ARKitScenes gives its frames and its mesh", "[layout.arkitscenes]")
{
    check_marks(layout);
    const WrittenRecording video(layout);
    TestRun run(2);
    const auto found = video.read(run);
    check_same_recording(*found.frames, video.frames, video.images);
    CHECK(found.mesh != nullptr);
    CHECK(found.frames->frames[2].name == "41069021_305.577");
    check_damage(video, {"lowres_wide.traj", "confidence/41069021_305.477.png", "lowres_depth/41069021_305.477.png"});
}

TEST_CASE("ARKitScenes: depth below min_confidence counts as none", "[layout.arkitscenes]")
{
    const WrittenRecording video(layout);
    Raster8 confidence(16, 12, 3);
    video.write("confidence/41069021_305.477.png", "");
    write_file(video.path / "confidence/41069021_305.477.png", video.images.encode_png(confidence));
    const auto has_depth = [&](const Value& options)
    {
        const auto depth = load_depth_steps(video.read(options).frames->frames[1], &video.images);
        return std::ranges::any_of(depth.values, [](auto step) { return step > 0; });
    };
    CHECK_FALSE(has_depth(Value::Map{}));
    CHECK(has_depth(Value::Map{{"min_confidence", 0}}));
}

TEST_CASE("pictures without a pose at their time or without depth are left out and counted", "[layout.arkitscenes]")
{
    const WrittenRecording video(layout);
    video.replace("lowres_wide.traj", "305.479", "305.499");
    video.remove("lowres_depth/41069021_305.377.png");
    TestRun run;
    CHECK(video.read(run).frames->frames.size() == 1);
    CHECK(run.reported.at("without_pose").as_int() == 1);
    CHECK(run.reported.at("without_depth").as_int() == 1);
}

TEST_CASE("a video of ARKitScenes that cannot be used is refused by name", "[layout.arkitscenes]")
{
    check_flaws(layout, {{replacing("lowres_wide.traj", "305.377 ", ""), {"lowres_wide.traj:1: 6 numbers; expected 7"}},
                         {writing("lowres_wide_intrinsics/41069021_305.477.pincam", "32 24 30.5"),
                          {"305.477.pincam: 3 numbers; expected width, height, fx, fy, cx, cy"}},
                         {removing("lowres_wide_intrinsics/41069021_305.477.pincam"), {"1 file is missing", "305.477.pincam"}},
                         {writing("lowres_wide/a_b.png", ""), {"a_b.png: the time in the file's name"}}});
}
