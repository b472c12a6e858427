#include "layout_test.h"
#include "replica_scene.h"

namespace
{

const LayoutUnderTest layout{.type = "layout.replica",
                             .write =
                                 [](const Frames& frames, const fs::path& folder, const ImageIo&)
                             {
                                 write_replica(frames, folder / "room0");
                                 write_mesh(folder / "room0_mesh.ply");
                                 // With a slash behind it, as shells complete it.
                                 return folder / "room0/";
                             },
                             .color = "results/frame000001.jpg",
                             .depth = "results/depth000001.png",
                             .pose_source = "traj.txt:2",
                             .damaged = {"traj.txt", "../cam_params.json", "../room0_mesh.ply"},
                             .third = "results frame000002 2",
                             .mesh_faces = 1,
                             .files_read = 3 + 2 * 3};

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("the camera has the steps of depth per meter; it and the mesh may be elsewhere, frames may be left out",
          "[layout.replica]")
{
    const WrittenRecording scene(layout);
    const auto beside = scene.path / "..";
    scene.replace("../cam_params.json", "1000", "6553.5");
    CHECK(scene.read().frames->frames[0].depth_unit_m == Approx(0.000152590));
    fs::rename(beside / "cam_params.json", beside / "other.json");
    CHECK_THAT(scene.error(), Contains("the scene's camera is missing") && Contains("room0/cam_params.json or "));
    fs::rename(beside / "other.json", scene.path / "cam_params.json");
    CHECK(scene.error() == "no error");
    fs::rename(beside / "room0_mesh.ply", beside / "other.ply");
    check_no_mesh(scene, "room0_mesh.ply");
    CHECK(scene.error(Value::Map{{"mesh", (beside / "other.ply").string()}}) == "no error");
    fs::rename(beside / "other.ply", scene.path / "mesh.ply");
    scene.remove("results/frame000001.jpg");
    scene.remove("results/depth000001.png");
    const auto frames = scene.read().frames->frames;
    REQUIRE(frames.size() == 2);
    CHECK(frames[1].color.world_from_camera.translation.z == Approx(1.0 / 3 + 2));
}

TEST_CASE("a scene that cannot be used is refused by name", "[layout.replica]")
{
    check_flaws(
        layout,
        {{[](const auto& it) { it.write("traj.txt", it.text("traj.txt").substr(0, it.text("traj.txt").find('\n') + 1)); },
          {"traj.txt: 1 poses, but frame 1 has pictures"}},
         {[](const auto& it) { it.write("traj.txt", "1 2 3\n" + it.text("traj.txt")); }, {"traj.txt:1: 3 numbers; expected 16"}},
         {removing("results"), {"holds no views; each needs results/frameN.jpg (or .png) and results/depthN.png"}},
         {writing("../cam_params.json", R"({"camera": {"w": 32, "h": 24, "fx": 30}})"),
          {"cam_params.json: camera.scale: missing"}},
         {writing("../cam_params.json", R"({"camera": 3})"), {"cam_params.json: camera: expected a map"}}});
}
