#include "layout_test.h"
#include "lzfse_packer.h"
#include "metadata.h"

#include <fresco/zip.h>

#include <cstring>

namespace
{

/// The camera of the first frame stands at the origin of the poses, and `initPose` says where it was.
fs::path write_record3d(const Frames& frames, const fs::path& folder, const ImageIo& images)
{
    const auto pose = [](const RigidTransform& world_from_camera)
    {
        const RigidTransform cv_from_gl{{{1, 0, 0, 0, -1, 0, 0, 0, -1}}, {}};
        const auto t = world_from_camera * cv_from_gl;
        const auto q = quaternion_of(t.rotation);
        return Value::List{q[1], q[2], q[3], q[0], t.translation.x, t.translation.y, t.translation.z};
    };
    const RigidTransform flip{{{1, 0, 0, 0, -1, 0, 0, 0, -1}}, {}};
    const auto& first = frames.frames.front().color;
    Value::List poses, cameras;
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        poses.emplace_back(pose(flip * first.world_from_camera.inverse() * frame.color.world_from_camera));
        const auto& k = frame.color.intrinsics;
        cameras.emplace_back(Value::List{k.fx, k.fy, k.cx, k.cy});
        const auto name = std::to_string(i);
        copy_picture(frame.color_picture.path, folder / "rgbd" / (name + ".jpg"));
        const auto depth = load_depth(frame, &images);
        std::string meters(reinterpret_cast<const char*>(depth.values.data()), depth.values.size() * sizeof(float));
        write_file(folder / "rgbd" / (name + ".depth"), record3d::testing::stored_block(meters) + "bvx$");
        write_file(folder / "rgbd" / (name + ".conf"),
                   record3d::testing::stored_block(std::string(depth.values.size(), '\2')) + "bvx$");
    }
    const auto& k = first.intrinsics;
    const Value metadata = Value::Map{{"w", k.width},
                                      {"h", k.height},
                                      {"dw", frames.frames.front().depth.intrinsics.width},
                                      {"dh", frames.frames.front().depth.intrinsics.height},
                                      {"K", Value::List{k.fx, 0, 0, 0, k.fy, 0, k.cx, k.cy, 1}},
                                      {"perFrameIntrinsicCoeffs", cameras},
                                      {"poses", poses},
                                      {"initPose", pose(first.world_from_camera)}};
    write_file(folder / "metadata", to_json(metadata));
    return folder;
}

const LayoutUnderTest layout{.type = "layout.record3d",
                             .write = write_record3d,
                             .pose_source = "metadata",
                             .damaged = {"metadata", "rgbd/1.depth", "rgbd/1.conf"}};

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("Record3D: depth below min_confidence counts as none", "[layout.record3d]")
{
    const WrittenRecording recording(layout);
    std::string levels(16 * 12, '\2');
    levels[0] = 1;
    levels[17] = 0;
    levels[18] = 1;
    recording.write("rgbd/1.conf", record3d::testing::stored_block(levels) + "bvx$");
    const auto depth = [&](const Value& options)
    { return load_depth_steps(recording.read(options).frames->frames[1], &recording.images).values; };
    const auto all = depth(Value::Map{{"min_confidence", 0}}), some = depth(Value::Map{{"min_confidence", 1}}),
               sure = depth(Value::Map{});
    CHECK((all[17] > 0 && some[17] == 0 && sure[17] == 0));
    CHECK((all[18] > 0 && some[18] > 0 && sure[18] == 0));
    CHECK((all[19] > 0 && all[19] == sure[19]));
    recording.remove("rgbd/1.conf");
    CHECK(depth(Value::Map{}) == all);
}

TEST_CASE("metadata of older recordings: one camera, no size of the depth pictures", "[layout.record3d]")
{
    const auto metadata = record3d::parse_metadata(
        R"({"w": 720, "h": 960, "K": [700, 0, 0, 0, 710, 0, 360, 480, 1], "poses": [[0, 0, 0, 1, 1, 2, 3], [1, 0, 0, 0, 4, 5, 6]]})",
        "metadata");
    CHECK((metadata.depth_width == 192 && metadata.depth_height == 256));
    REQUIRE(metadata.cameras.size() == 1);
    CHECK(metadata.cameras[0] == Intrinsics{720, 960, 700, 710, 360, 480});
    // Half a turn around x is OpenGL's camera turned into OpenCV's.
    REQUIRE(metadata.world_from_camera.at(1));
    CHECK(metadata.world_from_camera[1]->point({0, 0, 1}) == Vec3d{4, 5, 7});
    REQUIRE(metadata.world_from_camera[0]);
    CHECK(metadata.world_from_camera[0]->point({0, 1, 0}) == Vec3d{1, 1, 3});
}

TEST_CASE("an .r3d file gives the frames of its folder", "[layout.record3d]")
{
    const LayoutUnderTest zipped{.type = "layout.record3d",
                                 .write =
                                     [](const Frames& frames, const fs::path& folder, const ImageIo& images)
                                 {
                                     write_record3d(frames, folder, images);
                                     const auto file = folder.parent_path() / "room.r3d";
                                     ZipWriter zip(file);
                                     for (const auto& entry : fs::recursive_directory_iterator(folder))
                                         if (entry.is_regular_file())
                                         {
                                             zip.begin(entry.path().lexically_relative(folder).string());
                                             zip.write(read_text_file(entry.path()));
                                         }
                                     zip.finish();
                                     return file;
                                 },
                                 .pose_source = "metadata"};
    const WrittenRecording recording(zipped);
    check_same_recording(*recording.read().frames, recording.frames, recording.images);
    check_damage(recording, {""});
}

TEST_CASE("a recording of Record3D that cannot be used is refused by name", "[layout.record3d]")
{
    const auto same_poses = [](auto& it)
    {
        const auto text = read_text_file(it.path / "metadata");
        auto metadata = parse_json(text, "metadata");
        metadata.set("poses", Value::List(3, Value::List{0, 0, 0, 1, 0, 0, 0}));
        it.write("metadata", to_json(metadata));
    };
    check_flaws(layout, {{same_poses, {"metadata: poses: all poses are the same", "front camera"}},
                         {removing("rgbd/1.depth"), {"rgbd/1.depth", "1 file is missing"}},
                         {writing("rgbd/1.depth", "bvx2"), {"rgbd/1.depth"}},
                         {replacing("metadata", "\"dw\":16", "\"dw\":15"), {"more than the 720 bytes"}},
                         {writing("rgbd/3.jpg", ""), {"rgbd/3.depth"}}});
}
