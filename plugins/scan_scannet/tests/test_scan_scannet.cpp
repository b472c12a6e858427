#include "scene_frames.h"

#include "reader_damage.h"

#include <fresco/error.h>
#include <fresco/mesh_io.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <algorithm>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

const char* const lost_pose = "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n";
const char* const identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

fresco::Mesh triangle(float size)
{
    fresco::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

/// A scene "scene0000_00" of the views 0, 2 and 10; view 2 has no pose. Color 64x48, depth 32x24.
struct TinyScene
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;

    TinyScene()
    {
        for (const char* name : {"color", "depth", "pose", "intrinsic"})
            fs::create_directories(path() / name);
        for (const char* number : {"0", "2", "10"})
        {
            const std::string name = number;
            fresco::write_file(path() / "color" / (name + ".jpg"), images.encode_jpeg(fresco::Raster8(64, 48, 3, 7), 95));
            fresco::write_file(path() / "depth" / (name + ".png"), images.encode_png(fresco::Raster16(32, 24, 1, 1500)));
            write("pose/" + name + ".txt", name == "2" ? lost_pose : "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n");
        }
        write("intrinsic/intrinsic_color.txt", "50 0 31.5 0\n0 51 23.5 0\n0 0 1 0\n0 0 0 1\n");
        write("intrinsic/intrinsic_depth.txt", "25 0 15.5 0\n0 26 11.5 0\n0 0 1 0\n0 0 0 1\n");
        write("intrinsic/extrinsic_color.txt", "1 0 0 0.03\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        write("intrinsic/extrinsic_depth.txt", "1 0 0 0.01\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        write("scene0000_00.txt",
              "axisAlignment = 0 1 0 0 -1 0 0 0 0 0 1 2 0 0 0 1 \ncolorWidth = 64\nfx_color = 40\nfy_color = 41\n"
              "mx_color = 30.5\nmy_color = 22.5\nfx_depth = 20\nfy_depth = 21\nmx_depth = 14.5\nmy_depth = 10.5\n");
        fresco::write_file(path() / "scene0000_00_vh_clean.ply", fresco::to_ply(triangle(1)));
        fresco::write_file(path() / "scene0000_00_vh_clean_2.ply", fresco::to_ply(triangle(2)));
    }

    fs::path path() const { return folder.path() / "scene0000_00"; }
    void write(const std::string& name, std::string_view text) const { fresco::write_file(path() / name, text); }
};

struct Result : fresco::testing::ReadScan
{
    fresco::testing::TemporaryFolder out;
};

void run_scan(const fs::path& path, const fresco::Value& options, TestRun& run, Result& result, const RawImages& images = {})
{
    static_cast<fresco::testing::ReadScan&>(result) =
        fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.scannet", path, images, result.out.path(), run, options);
}

std::string error_of(const TinyScene& scene, const fresco::Value& options = fresco::Value::Map{})
{
    return fresco::testing::error_text(
        [&]
        {
            TestRun run;
            Result result;
            run_scan(scene.path(), options, run, result, scene.images);
        });
}

}  // namespace

TEST_CASE("an exported scene becomes frames by number, without the lost ones", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun run;
    Result result;
    run_scan(scene.path(), fresco::Value::Map{}, run, result);
    const auto& frames = result.frames->frames;
    REQUIRE(frames.size() == 2);
    CHECK(frames[0].number == 0);
    CHECK(frames[1].number == 10);
    CHECK(frames[1].name == "10");
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
    CHECK(run.reported.at("mesh").as_string() == "scene0000_00_vh_clean.ply");
    // The files count pixel centers from 0.
    CHECK(frames[0].color.intrinsics == fresco::Intrinsics{64, 48, 50, 51, 32, 24});
    CHECK(frames[0].depth.intrinsics == fresco::Intrinsics{32, 24, 25, 26, 16, 12});
    CHECK(frames[0].depth.world_from_camera.translation == fresco::Vec3d{5, 6, 7});
    // In the recorder's frame color is at x = 0.03 and depth at 0.01; the pose turns x into y.
    const auto color = frames[0].color.world_from_camera.translation;
    CHECK(color.x == Approx(5));
    CHECK(color.y == Approx(6.02));
    CHECK(color.z == Approx(7));
    CHECK(fresco::load_depth(frames[0], &scene.images).at(3, 3) == Approx(1.5f));
    CHECK(result.mesh->positions[1] == fresco::Vec3f{1, 0, 0});
    CHECK(run.files_read.size() == 3 * 3 + 4 + 1 + 1);
    std::vector<fs::path> names;
    for (const char* pattern : {"color/*.jpg", "color/*.png", "depth/*.png", "pose/*.txt", "intrinsic/*.txt", "intrinsic",
                                "scene0000_00.txt", "*_vh_clean.ply"})
        names.push_back(scene.path() / pattern);
    CHECK(run.folders_read == names);
}

TEST_CASE("the mesh is chosen by kind", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun run;
    Result result;
    run_scan(scene.path(), fresco::Value::Map{{"mesh_kind", "reduced"}}, run, result);
    CHECK(result.mesh->positions[1].x == 2);
    fs::remove(scene.path() / "scene0000_00_vh_clean.ply");
    TestRun without_full;
    run_scan(scene.path(), fresco::Value::Map{}, without_full, result);
    CHECK(result.mesh->positions[1].x == 2);
    // The full one would be taken if it came back.
    CHECK(without_full.folders_read.back() == scene.path() / "*_vh_clean_2.ply");
    CHECK(without_full.folders_read.rbegin()[1] == scene.path() / "*_vh_clean.ply");
    fs::rename(scene.path() / "scene0000_00.txt", scene.path() / "other.txt");
    TestRun renamed;
    run_scan(scene.path(), fresco::Value::Map{}, renamed, result);
    CHECK(std::count(renamed.folders_read.begin(), renamed.folders_read.end(), scene.path() / "*.txt") == 1);
    CHECK_THAT(error_of(scene, fresco::Value::Map{{"mesh_kind", "full"}}), Contains("no mesh *_vh_clean.ply"));
    fs::copy_file(scene.path() / "scene0000_00_vh_clean_2.ply", scene.path() / "other_vh_clean_2.ply");
    CHECK_THAT(error_of(scene), Contains("several meshes") && Contains("other_vh_clean_2.ply"));
    const auto named = fresco::Value::Map{{"mesh", (scene.path() / "other_vh_clean_2.ply").string()}};
    CHECK(error_of(scene, named) == "no error");
}

TEST_CASE("axis alignment moves cameras and mesh alike", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun run;
    Result result;
    run_scan(scene.path(), fresco::Value::Map{{"align_axes", true}}, run, result);
    // (x, y, z) becomes (y, -x, z + 2).
    CHECK(result.frames->frames[0].depth.world_from_camera.translation == fresco::Vec3d{6, -5, 9});
    CHECK(result.mesh->positions[1] == fresco::Vec3f{0, -1, 2});
    fs::remove(scene.path() / "scene0000_00.txt");
    CHECK_THAT(error_of(scene, fresco::Value::Map{{"align_axes", true}}), Contains("no axisAlignment"));
}

TEST_CASE("without the folder intrinsic the scene's properties are used", "[scan.scannet]")
{
    const TinyScene scene;
    fs::remove_all(scene.path() / "intrinsic");
    TestRun run;
    Result result;
    run_scan(scene.path(), fresco::Value::Map{{"pixel_center", "half"}}, run, result);
    CHECK(result.frames->frames[0].color.intrinsics == fresco::Intrinsics{64, 48, 40, 41, 30.5, 22.5});
    CHECK(result.frames->frames[0].color.world_from_camera == result.frames->frames[0].depth.world_from_camera);
    scene.write("scene0000_00.txt", "fx_color = 40\nfy_color = 41\n");
    CHECK_THAT(error_of(scene), Contains("scene0000_00.txt: the property mx_color is missing"));
    fs::remove(scene.path() / "scene0000_00.txt");
    CHECK_THAT(error_of(scene), Contains("no calibration"));
}

TEST_CASE("results do not depend on the thread count", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun one(1), two(2);
    Result a, b;
    run_scan(scene.path(), fresco::Value::Map{}, one, a);
    run_scan(scene.path(), fresco::Value::Map{}, two, b);
    CHECK(fresco::read_text_file(a.out.path() / "frames/frames.json") ==
          fresco::read_text_file(b.out.path() / "frames/frames.json"));
}

TEST_CASE("every counts views, lost ones included", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun run;
    Result result;
    run_scan(scene.path(), fresco::Value::Map{{"every", 2}}, run, result);
    CHECK(result.frames->frames.size() == 2);
    run_scan(scene.path(), fresco::Value::Map{{"every", 3}}, run, result);
    CHECK(result.frames->frames.size() == 1);
}

TEST_CASE("a scene that cannot be used is refused by name", "[scan.scannet]")
{
    TinyScene scene;
    SECTION("a folder is missing")
    {
        fs::remove_all(scene.path() / "pose");
        CHECK_THAT(error_of(scene), Contains("scene0000_00/pose: no such folder"));
    }
    SECTION("no views")
    {
        for (const char* name : {"color", "depth", "pose"})
        {
            fs::remove_all(scene.path() / name);
            fs::create_directory(scene.path() / name);
        }
        CHECK_THAT(error_of(scene), Contains("the scene has no views"));
    }
    SECTION("partners missing")
    {
        fs::remove(scene.path() / "depth/10.png");
        fs::remove(scene.path() / "color/0.jpg");
        CHECK_THAT(error_of(scene), Contains("2 files are missing") && Contains("color/0.jpg") && Contains("depth/10.png"));
    }
    SECTION("a number twice")
    {
        fs::copy_file(scene.path() / "color/0.jpg", scene.path() / "color/00.jpg");
        CHECK_THAT(error_of(scene), Contains("another file of this number"));
    }
    SECTION("all poses lost")
    {
        scene.write("pose/0.txt", lost_pose);
        scene.write("pose/10.txt", lost_pose);
        CHECK_THAT(error_of(scene), Contains("none of the 3 poses is finite"));
    }
    SECTION("a pose that is no rotation")
    {
        scene.write("pose/10.txt", "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scene), Contains("pose/10.txt") && Contains("not a rotation"));
    }
    SECTION("a pose that cannot be parsed")
    {
        scene.write("pose/10.txt", "1 0 0 0\n0 1 0\n");
        CHECK_THAT(error_of(scene), Contains("pose/10.txt:2: 3 numbers"));
    }
    SECTION("intrinsics for another size")
    {
        scene.write("intrinsic/intrinsic_color.txt", "1170 0 647 0\n0 1170 483 0\n0 0 1 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scene), Contains("intrinsic_color.txt") && Contains("64x48"));
    }
    SECTION("intrinsics missing")
    {
        fs::remove(scene.path() / "intrinsic/intrinsic_depth.txt");
        CHECK_THAT(error_of(scene), Contains("intrinsic_depth.txt"));
    }
    SECTION("a picture of another size")
    {
        fresco::write_file(scene.path() / "depth/10.png", scene.images.encode_png(fresco::Raster16(24, 32, 1, 1500)));
        CHECK_THAT(error_of(scene), Contains("depth/10.png: the picture is 24x32"));
    }
    SECTION("a picture that EXIF turns")
    {
        scene.images.orientation = 6;
        CHECK_THAT(error_of(scene), Contains("color/0.jpg: its EXIF data says") && Contains("pose/0.txt means the pixels"));
    }
    SECTION("a pose beyond all rooms")
    {
        scene.write("pose/10.txt", "1 0 0 0\n0 1 0 2e7\n0 0 1 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scene), Contains("pose/10.txt: the camera is more than 1e7 m"));
    }
    SECTION("a property line")
    {
        scene.write("scene0000_00.txt", "colorWidth = 64\nnonsense\n");
        CHECK_THAT(error_of(scene), Contains("scene0000_00.txt:2: expected"));
    }
    SECTION("an alignment that is none")
    {
        scene.write("scene0000_00.txt", "axisAlignment = 1 0 0\n");
        CHECK_THAT(error_of(scene), Contains("axisAlignment: 3 numbers; expected 16"));
    }
    SECTION("extrinsics that are none")
    {
        scene.write("intrinsic/extrinsic_depth.txt", std::string(identity).replace(0, 1, "3"));
        CHECK_THAT(error_of(scene), Contains("extrinsic_depth.txt") && Contains("not a rotation"));
    }
}

TEST_CASE("a run can be stopped", "[scan.scannet]")
{
    const TinyScene scene;
    TestRun run;
    run.cancel_after(2);
    Result result;
    CHECK_THROWS_AS(run_scan(scene.path(), fresco::Value::Map{}, run, result), fresco::Canceled);
}

TEST_CASE("damage to a scene gives an error or what can be used", "[scan.scannet]")
{
    const TinyScene scene;
    const fresco::testing::TemporaryFolder out;
    const auto path = scene.path();
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.scannet", path, scene.images, out.path(),
                                  {{path / "pose/10.txt", 180, 200},
                                   {path / "intrinsic/intrinsic_color.txt", 180, 200},
                                   {path / "intrinsic/intrinsic_depth.txt", 180, 200},
                                   {path / "intrinsic/extrinsic_color.txt", 180, 200},
                                   {path / "intrinsic/extrinsic_depth.txt", 180, 200},
                                   {path / "color/10.jpg"},
                                   {path / "depth/0.png"},
                                   {path / "scene0000_00_vh_clean.ply", 200, 100}});
    fs::remove_all(path / "intrinsic");
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.scannet", path, scene.images, out.path(),
                                  {{path / "scene0000_00.txt", 199, 100}});
}
