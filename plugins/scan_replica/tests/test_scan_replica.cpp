#include "replica_scene.h"

#include "reader_damage.h"

#include <fresco/error.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::Value;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

struct TinyScene
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = fresco::testing::tiny_recording(folder.path(), images);

    TinyScene()
    {
        fresco::testing::write_replica(frames, path());
        fresco::Mesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}};
        fresco::write_file(path().parent_path() / "room0_mesh.ply", fresco::to_ply(mesh));
    }
    fs::path path() const { return folder.path() / "replica/room0"; }
    fs::path camera() const { return path().parent_path() / "cam_params.json"; }
    void write(const fs::path& file, std::string_view text) const { fresco::write_file(file, text); }
};

fresco::testing::ReadScan read(const TinyScene& scene, TestRun& run, const Value& options = Value::Map{})
{
    // With a slash behind it, as shells complete it.
    return fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.replica", scene.path().string() + "/", scene.images,
                                       scene.folder.path() / "out", run, options);
}

std::string error_of(const TinyScene& scene, const Value& options = Value::Map{})
{
    return fresco::testing::reading_error([&](TestRun& run) { read(scene, run, options); });
}

}  // namespace

TEST_CASE("a scene is read back", "[scan.replica]")
{
    const TinyScene scene;
    TestRun run;
    const auto result = read(scene, run);
    fresco::testing::check_same_recording(*result.frames, scene.frames, scene.images);
    CHECK(result.frames->frames[2].name == "frame000002");
    CHECK(result.frames->frames[2].number == 2);
    CHECK(result.mesh->triangles.size() == 1);
    CHECK(run.reported.at("mesh").as_string() == "room0_mesh.ply");
    CHECK(run.files_read.size() == 3 + 2 * 3);
    CHECK(read(scene, run, Value::Map{{"every", 2}}).frames->frames[1].number == 2);
}

TEST_CASE("pixel centers count from 0 and depth in steps per meter", "[scan.replica]")
{
    const auto camera = replica::parse_camera(
        R"({"camera": {"w": 1200, "h": 680, "fx": 600.0, "fy": 601.0, "cx": 599.5, "cy": 339.5, "scale": 6553.5}})", "x");
    CHECK(camera.intrinsics == fresco::Intrinsics{1200, 680, 600, 601, 600, 340});
    CHECK(camera.depth_unit_m == Approx(0.000152590));
    const auto poses = replica::parse_trajectory("0 -1 0 4 1 0 0 5 0 0 1 6 0 0 0 1\n", "x");
    CHECK(poses.at(0).point({1, 0, 0}) == fresco::Vec3d{4, 6, 6});
}

TEST_CASE("the mesh and the camera may be elsewhere, frames may be left out", "[scan.replica]")
{
    const TinyScene scene;
    fs::rename(scene.camera(), scene.folder.path() / "other.json");
    CHECK_THAT(error_of(scene), Contains("the scene's camera is missing") && Contains("room0/cam_params.json or "));
    CHECK(error_of(scene, Value::Map{{"camera", (scene.folder.path() / "other.json").string()}}) == "no error");
    fs::rename(scene.folder.path() / "other.json", scene.path() / "cam_params.json");
    CHECK(error_of(scene) == "no error");
    fs::rename(scene.path().parent_path() / "room0_mesh.ply", scene.folder.path() / "other.ply");
    CHECK_THAT(error_of(scene), Contains("the scene's mesh is missing") && Contains("room0_mesh.ply"));
    CHECK(error_of(scene, Value::Map{{"mesh", (scene.folder.path() / "other.ply").string()}}) == "no error");
    fs::rename(scene.folder.path() / "other.ply", scene.path() / "mesh.ply");
    fs::remove(scene.path() / "results/frame000001.jpg");
    CHECK_THAT(error_of(scene), Contains("1 file is missing: the color picture beside") && Contains("depth000001.png"));
    fs::remove(scene.path() / "results/depth000001.png");
    TestRun run;
    const auto frames = read(scene, run).frames->frames;
    REQUIRE(frames.size() == 2);
    CHECK(frames[1].color.world_from_camera.translation.z == Approx(1.0 / 3 + 2));
}

TEST_CASE("a scene that cannot be used is refused by name", "[scan.replica]")
{
    const TinyScene scene;
    const auto trajectory = fresco::read_text_file(scene.path() / "traj.txt");
    SECTION("too few poses")
    {
        scene.write(scene.path() / "traj.txt", trajectory.substr(0, trajectory.find('\n') + 1));
        CHECK_THAT(error_of(scene), Contains("traj.txt: 1 poses, but there are pictures of frame 1"));
    }
    SECTION("a pose that is none")
    {
        scene.write(scene.path() / "traj.txt", "1 2 3\n" + trajectory);
        CHECK_THAT(error_of(scene), Contains("traj.txt:1: 3 numbers; expected 16"));
    }
    SECTION("no pictures")
    {
        fs::remove_all(scene.path() / "results");
        CHECK_THAT(error_of(scene), Contains("results: no pictures; expected frame000000.jpg"));
    }
    SECTION("a number twice")
    {
        fs::copy_file(scene.path() / "results/frame000001.jpg", scene.path() / "results/frame01.png");
        CHECK_THAT(error_of(scene), Contains("there is another picture of this number"));
    }
    SECTION("a camera that is none")
    {
        scene.write(scene.camera(), R"({"camera": {"w": 32, "h": 24, "fx": 30}})");
        CHECK_THAT(error_of(scene), Contains("cam_params.json: camera: \"scale\" is missing"));
        scene.write(scene.camera(), R"({"cameras": 3})");
        CHECK_THAT(error_of(scene), Contains("cam_params.json: expected {\"camera\""));
        scene.write(scene.camera(), R"({"camera": 3})");
        CHECK_THAT(error_of(scene), Contains("cam_params.json: camera: expected a map"));
    }
}

TEST_CASE("damage to a scene gives an error or what can be used", "[scan.replica]")
{
    const TinyScene scene;
    const auto results = scene.path() / "results";
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.replica", scene.path(), scene.images, scene.folder.path() / "out",
                                  {{scene.path() / "traj.txt", 200, 150},
                                   {scene.camera(), 200, 150},
                                   {results / "frame000001.jpg"},
                                   {results / "depth000002.png"},
                                   {scene.path().parent_path() / "room0_mesh.ply", 200, 100}});
}
