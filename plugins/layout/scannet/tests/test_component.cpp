#include "layout_test.h"

#include <algorithm>

namespace
{

const char* const lost_pose = "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n";
const char* const properties = "scene0000_00.txt";

/// A scene of the views 0, 2, 10, with its full mesh and a reduced one of twice its size.
fs::path write_scannet(const Frames& frames, const fs::path& scene)
{
    const char* const numbers[] = {"0", "2", "10"};
    fs::create_directories(scene / "pose");
    fs::create_directories(scene / "intrinsic");
    for (std::size_t i = 0; i < 3; ++i)
    {
        const auto& frame = frames.frames[i];
        const std::string name = numbers[i];
        copy_picture(frame.color_picture.path, scene / "color" / (name + ".jpg"));
        copy_picture(frame.depth_picture.path, scene / "depth" / (name + ".png"));
        write_file(scene / "pose" / (name + ".txt"), rows_of(matrix_of(frame.depth.world_from_camera), 4));
    }
    const auto& first = frames.frames.front();
    // The recorder's own frame is a centimeter beside the depth camera's.
    const RigidTransform rig_from_depth{{}, {0.01, 0, 0}};
    const auto rig_from_color = rig_from_depth * first.depth.world_from_camera.inverse() * first.color.world_from_camera;
    for (const auto& [name, k, rig_from_camera] : {std::tuple{"color.txt", first.color.intrinsics, rig_from_color},
                                                   std::tuple{"depth.txt", first.depth.intrinsics, rig_from_depth}})
    {
        write_file(scene / "intrinsic" / (std::string("intrinsic_") + name),
                   rows_of({k.fx, 0, k.cx - 0.5, 0, 0, k.fy, k.cy - 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 4));
        write_file(scene / "intrinsic" / (std::string("extrinsic_") + name), rows_of(matrix_of(rig_from_camera), 4));
    }
    write_file(scene / properties,
               "colorWidth = 64\nfx_color = 40\nfy_color = 41\n"
               "mx_color = 15.5\nmy_color = 12.5\nfx_depth = 20\nfy_depth = 21\nmx_depth = 7.5\nmy_depth = 6.5\n");
    write_mesh(scene / "scene0000_00_vh_clean.ply");
    write_mesh(scene / "scene0000_00_vh_clean_2.ply", 1, 2);
    return scene;
}

const LayoutUnderTest layout{.type = "layout.scannet",
                             .write = [](const Frames& frames, const fs::path& folder, const ImageIo&)
                             { return write_scannet(frames, folder / "scene0000_00"); },
                             .color = "color/2.jpg",
                             .depth = "depth/2.png",
                             .pose_source = "pose/2.txt",
                             .damaged = {"pose/10.txt", "intrinsic/intrinsic_color.txt", "intrinsic/intrinsic_depth.txt",
                                         "intrinsic/extrinsic_color.txt", "intrinsic/extrinsic_depth.txt",
                                         "scene0000_00_vh_clean.ply"},
                             .has_depth_camera = true,
                             .third = "scene 10 10",
                             .mesh_faces = 1,
                             .files_read = 3 * 3 + 4 + 1};

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("the extrinsics lead to the recorder's frame, poses are the depth camera's", "[layout.scannet]")
{
    const WrittenRecording scene(layout);
    scene.write("pose/0.txt", "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n");
    scene.write("intrinsic/extrinsic_color.txt", "1 0 0 0.03\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    // In the recorder's frame color is at x = 0.03 and depth at 0.01; the pose turns x into y.
    const auto frame = scene.read().frames->frames[0];
    CHECK(frame.depth.world_from_camera.translation == Vec3d{5, 6, 7});
    CHECK(length(frame.color.world_from_camera.translation - Vec3d{5, 6.02, 7}) < 1e-12);
}

TEST_CASE("views without a pose are left out, every counts them", "[layout.scannet]")
{
    const WrittenRecording scene(layout);
    scene.write("pose/2.txt", lost_pose);
    TestRun run;
    CHECK(scene.read(run).frames->frames.size() == 2);
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
    CHECK(run.messages == std::vector<std::string>{"2 frames, 1 left out because their pose is not finite"});
    CHECK(scene.read(Value::Map{{"every", 2}}).frames->frames.size() == 2);
    scene.write("pose/0.txt", lost_pose);
    scene.write("pose/10.txt", lost_pose);
    CHECK_THAT(scene.error(), Contains("none of the 3 poses is finite"));
}

TEST_CASE("the full mesh goes before the reduced one", "[layout.scannet]")
{
    const WrittenRecording scene(layout);
    TestRun whole;
    CHECK(scene.read(whole).mesh->positions[1].x == 1);
    for (const char* pattern : {"color/*.jpg", "color/*.png", "depth/*.png", "pose/*.txt", "intrinsic", "*_vh_clean.ply"})
        CHECK(std::ranges::count(whole.folders_read, scene.path / pattern) == 1);
    scene.remove("scene0000_00_vh_clean.ply");
    scene.remove("intrinsic");
    scene.write("other.txt", scene.text(properties));
    scene.remove(properties);
    TestRun run;
    CHECK(scene.read(run).mesh->positions[1].x == 2);
    // The full one would be taken if it came back, and another file of properties.
    for (const char* names : {"*_vh_clean.ply", "*_vh_clean_2.ply", "*.txt"})
        CHECK(std::ranges::count(run.folders_read, scene.path / names) == 1);
    const std::string reduced = scene.text("scene0000_00_vh_clean_2.ply");
    scene.remove("scene0000_00_vh_clean_2.ply");
    check_no_mesh(scene, "_vh_clean_2.ply");
    scene.write("scene0000_00_vh_clean_2.ply", reduced);
    scene.write("other_vh_clean_2.ply", scene.text("scene0000_00_vh_clean_2.ply"));
    CHECK_THAT(scene.error(), Contains("several meshes") && Contains("other_vh_clean_2.ply"));
    CHECK(scene.error(Value::Map{{"mesh", (scene.path / "other_vh_clean_2.ply").string()}}) == "no error");
}

TEST_CASE("without the folder intrinsic the scene's properties are used", "[layout.scannet]")
{
    const WrittenRecording scene(layout);
    scene.remove("intrinsic");
    const auto frame = scene.read(Value::Map{{"pixel_center", "half"}}).frames->frames[0];
    CHECK(frame.color.intrinsics == Intrinsics{32, 24, 40, 41, 15.5, 12.5});
    CHECK(frame.color.world_from_camera == frame.depth.world_from_camera);
    check_damage(scene, {properties});
    scene.write(properties, "fx_color = 40\nfy_color = 41\n");
    CHECK_THAT(scene.error(), Contains("scene0000_00.txt: the property mx_color is missing"));
    scene.remove(properties);
    CHECK_THAT(scene.error(), Contains("no calibration"));
}

TEST_CASE("a scene that cannot be used is refused by name", "[layout.scannet]")
{
    check_flaws(layout, {{removing("pose"), {"3 files are missing", "pose/0.txt", "pose/N.txt"}},
                         {writing("pose/10.txt", "1 0 0 0\n0 1 0\n"), {"pose/10.txt:2: 3 numbers"}},
                         {removing("intrinsic/intrinsic_depth.txt"), {"intrinsic_depth.txt"}},
                         {[](const auto& it)
                          {
                              it.remove("intrinsic");
                              it.write(properties, "colorWidth = 64\nnonsense\n");
                          },
                          {"scene0000_00.txt:2: expected"}},
                         {writing("intrinsic/extrinsic_depth.txt", "3 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
                          {"extrinsic_depth.txt", "not a rotation"}}});
}
