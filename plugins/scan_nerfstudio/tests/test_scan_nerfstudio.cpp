#include "transforms.h"

#include "reader_damage.h"

#include <fresco/error.h>
#include <fresco/stage.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

#include <cmath>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::Value;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

struct TinyScan
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = fresco::testing::tiny_recording(folder.path(), images);

    explicit TinyScan(const Value& head = Value::Map{}) { fresco::testing::write_nerfstudio(frames, path(), head); }
    fs::path path() const { return folder.path() / "scan"; }
    fs::path file() const { return path() / "transforms.json"; }
    Value json() const { return fresco::parse_json(fresco::read_text_file(file())); }
    void write(const Value& json) const { fresco::write_file(file(), fresco::to_json(json)); }
};

/// The frames that the stage gives, saved and loaded again.
fresco::Frames read(const TinyScan& scan, TestRun& run, const Value& options = Value::Map{})
{
    return *fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.nerfstudio", scan.path(), scan.images,
                                        scan.folder.path() / "out", run, options)
                .frames;
}

std::string error_of(const TinyScan& scan, const Value& options = Value::Map{})
{
    return fresco::testing::reading_error([&](TestRun& run) { read(scan, run, options); });
}

/// The value of `key` in one frame replaced.
void set_in_frame(const TinyScan& scan, std::size_t frame, std::string_view key, Value value)
{
    auto json = scan.json();
    json.find("frames")->as_list()[frame].set(key, std::move(value));
    scan.write(json);
}

}  // namespace

TEST_CASE("a recording written as transforms.json is read back", "[scan.nerfstudio]")
{
    const TinyScan scan;
    TestRun run;
    const auto frames = read(scan, run);
    fresco::testing::check_same_recording(frames, scan.frames, scan.images);
    CHECK(frames.frames[0].sequence == "images");
    CHECK(frames.frames[0].name == "frame_00001");
    CHECK(frames.frames[2].number == 3);
    CHECK(run.reported.at("has_depth").as_bool());
    CHECK(run.reported.at("undistorted").as_int() == 0);
    CHECK(run.files_read.size() == 1 + 2 * 3);
}

TEST_CASE("camera axes are OpenGL's", "[scan.nerfstudio]")
{
    // The unit matrix looks along -z with y up: OpenCV's y and z are turned.
    const auto read = nerfstudio::parse_transforms(
        R"({"w": 8, "h": 6, "camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "./train/r_0",
            "transform_matrix": [[1, 0, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]]}]})",
        "/data/transforms.json", {});
    REQUIRE(read.views.size() == 1);
    const auto& view = read.views[0];
    CHECK(view.world_from_camera.direction({0, 0, 1}) == fresco::Vec3d{0, 0, -1});
    CHECK(view.world_from_camera.direction({0, 1, 0}) == fresco::Vec3d{0, -1, 0});
    CHECK(view.world_from_camera.translation == fresco::Vec3d{4, 5, 6});
    // A right angle across 8 pixels; the middle where nothing is said.
    CHECK(view.camera.fx == Approx(4));
    CHECK(view.camera.fy == Approx(4));
    CHECK((view.camera.cx == 4 && view.camera.cy == 3));
    CHECK(view.color == "/data/./train/r_0.png");
    CHECK(view.depth.empty());
}

TEST_CASE("the recorder's own world is had back, in meters", "[scan.nerfstudio]")
{
    // saved = 2 * (y, x, -z): what the file has of a recorder's camera at (5, 6, 7) is at (12, 10, -14).
    const TinyScan scan(
        Value::Map{{"applied_transform", Value::List{Value::List{0, 1, 0, 0}, Value::List{1, 0, 0, 0}, Value::List{0, 0, -1, 0}}},
                   {"applied_scale", 2.0}});
    set_in_frame(
        scan, 0, "transform_matrix",
        Value::List{Value::List{1, 0, 0, 12}, Value::List{0, 1, 0, 10}, Value::List{0, 0, 1, -14}, Value::List{0, 0, 0, 1}});
    TestRun run;
    const auto original = read(scan, run, Value::Map{{"world", "original"}, {"unit_m", 0.1}});
    const auto& pose = original.frames[0].color.world_from_camera;
    CHECK(pose.translation.x == Approx(0.5));
    CHECK(pose.translation.y == Approx(0.6));
    CHECK(pose.translation.z == Approx(0.7));
    // It looks along the file's -z, which is the recorder's z; the file's x is the recorder's y.
    CHECK(pose.direction({0, 0, 1}) == fresco::Vec3d{0, 0, 1});
    CHECK(pose.direction({1, 0, 0}) == fresco::Vec3d{0, 1, 0});
    CHECK(read(scan, run).frames[0].color.world_from_camera.translation == fresco::Vec3d{12, 10, -14});
}

TEST_CASE("a frame's own values go before the file's", "[scan.nerfstudio]")
{
    const TinyScan scan(Value::Map{{"depth_unit_scale_factor", 0.002}});
    set_in_frame(scan, 1, "fl_x", 77);
    set_in_frame(scan, 1, "mask_path", "mask.png");
    set_in_frame(scan, 2, "camera_angle_x", 2 * std::atan(0.5));
    TestRun run;
    const auto frames = read(scan, run);
    CHECK(frames.frames[0].color.intrinsics.fx == 30.5);
    CHECK(frames.frames[1].color.intrinsics.fx == 77);
    CHECK(frames.frames[1].depth.intrinsics.fx == 38.5);
    // Half of 32 pixels at a tangent of 0.5; the angle stands for both directions.
    CHECK(frames.frames[2].color.intrinsics.fx == Approx(32));
    CHECK(frames.frames[2].color.intrinsics.fy == Approx(32));
    CHECK(frames.frames[1].depth_unit_m == 0.002);
    CHECK(std::count(run.messages.begin(), run.messages.end(),
                     "warning: the frames have masks (mask_path), which are not used") == 1);
    CHECK(read(scan, run, Value::Map{{"depth_unit_m", 0.004}}).frames[1].depth_unit_m == 0.004);
    CHECK(read(scan, run, Value::Map{{"every", 2}}).frames.size() == 2);
}

TEST_CASE("the file and the pictures may be elsewhere", "[scan.nerfstudio]")
{
    const TinyScan scan;
    const auto file = scan.folder.path() / "elsewhere/transforms_undistorted.json";
    fs::create_directories(file.parent_path());
    fs::rename(scan.file(), file);
    fs::rename(scan.path() / "depth", file.parent_path() / "depth");
    auto options = Value::Map{{"transforms", file.string()}};
    CHECK_THAT(error_of(scan, options), Contains("3 files are missing") && Contains("elsewhere/images/frame_00001.png"));
    options.emplace_back("pictures", scan.path().string());
    TestRun run;
    fresco::testing::check_same_recording(read(scan, run, options), scan.frames, scan.images);
}

TEST_CASE("distortion is undone", "[scan.nerfstudio]")
{
    const TinyScan scan(Value::Map{{"camera_model", "OPENCV"}, {"k1", 0.08}, {"k2", 0.0}, {"p1", 0.001}, {"p2", 0}});
    TestRun run;
    const auto frames = read(scan, run);
    CHECK(run.reported.at("undistorted").as_int() == 3);
    const auto& k = scan.frames.frames[0].color.intrinsics;
    const auto pinhole = fresco::recordings::pinhole_without({.k1 = 0.08, .p1 = 0.001}, k, "x");
    CHECK(frames.frames[0].color.intrinsics == pinhole);
    CHECK(fresco::load_color(frames.frames[1], &scan.images) ==
          fresco::recordings::undistorted(fresco::load_color(scan.frames.frames[1], &scan.images), k, {.k1 = 0.08, .p1 = 0.001},
                                          pinhole));
    CHECK_NOTHROW(fresco::load_depth(frames.frames[1], &scan.images));
}

TEST_CASE("frames without depth are given as such", "[scan.nerfstudio]")
{
    const TinyScan scan;
    auto json = scan.json();
    for (auto& frame : json.find("frames")->as_list())
        std::erase_if(frame.as_map(), [](const auto& entry) { return entry.first == "depth_file_path"; });
    scan.write(json);
    TestRun run;
    const auto frames = read(scan, run);
    CHECK(frames.frames[0].depth_picture.empty());
    CHECK_FALSE(run.reported.at("has_depth").as_bool());
    set_in_frame(scan, 1, "depth_file_path", "depth/frame_00002.png");
    CHECK_THAT(error_of(scan), Contains("1 of 3 frames have a depth_file_path"));
}

TEST_CASE("a file that cannot be used is refused by name", "[scan.nerfstudio]")
{
    const TinyScan scan;
    SECTION("no file")
    {
        fs::remove(scan.file());
        CHECK_THAT(error_of(scan), Contains("transforms.json"));
    }
    SECTION("no frames")
    {
        auto json = scan.json();
        json.set("frames", Value::List{});
        scan.write(json);
        CHECK_THAT(error_of(scan), Contains("transforms.json: \"frames\" must be a list of frames, not empty"));
    }
    SECTION("another camera")
    {
        set_in_frame(scan, 1, "camera_model", "OPENCV_FISHEYE");
        CHECK_THAT(error_of(scan), Contains("transforms.json: frame 1: \"camera_model\" is OPENCV_FISHEYE; PINHOLE"));
    }
    SECTION("an angle that is none")
    {
        for (const double degrees : {60.0, 0.0, -1.0})
        {
            set_in_frame(scan, 1, "camera_angle_x", degrees);
            CHECK_THAT(error_of(scan), Contains("frame 1: \"camera_angle_x\" must be an angle of view in radians"));
        }
    }
    SECTION("a focal length that is none")
    {
        set_in_frame(scan, 1, "fl_x", 1e-30);
        CHECK_THAT(error_of(scan), Contains("transforms.json: frame 1: a focal length of 1e-30 pixels"));
    }
    SECTION("a fourth coefficient")
    {
        set_in_frame(scan, 1, "k4", 0.1);
        CHECK_THAT(error_of(scan), Contains("frame 1: \"k4\" is not 0"));
        set_in_frame(scan, 1, "camera_model", "OPENCV");
        set_in_frame(scan, 1, "is_fisheye", true);
        CHECK_THAT(error_of(scan), Contains("transforms.json: frame 1: \"is_fisheye\" is set; fisheye lenses are not read"));
        set_in_frame(scan, 1, "is_fisheye", false);
        set_in_frame(scan, 1, "camera_model", "FULL_OPENCV");
        CHECK(error_of(scan) == "no error");
    }
    SECTION("a pinhole with distortion")
    {
        set_in_frame(scan, 1, "camera_model", "PINHOLE");
        CHECK(error_of(scan) == "no error");
        set_in_frame(scan, 1, "k1", 0.1);
        CHECK_THAT(error_of(scan), Contains("frame 1: \"camera_model\" is PINHOLE, but k1"));
    }
    SECTION("a pose that is none")
    {
        set_in_frame(scan, 2, "transform_matrix", Value::List{Value::List{1, 0, 0, 0}});
        CHECK_THAT(error_of(scan), Contains("frame 2: \"transform_matrix\": 4 numbers; expected a 4x4 matrix"));
        set_in_frame(scan, 2, "transform_matrix", "x");
        CHECK_THAT(error_of(scan), Contains("frame 2: \"transform_matrix\" must be a list of rows"));
    }
    SECTION("values of another kind")
    {
        set_in_frame(scan, 0, "fl_x", "585");
        CHECK_THAT(error_of(scan), Contains("frame 0: \"fl_x\" must be a number"));
        set_in_frame(scan, 0, "fl_x", 585);
        set_in_frame(scan, 0, "w", 32.5);
        CHECK_THAT(error_of(scan), Contains("frame 0: \"w\" must be a whole number of pixels"));
        set_in_frame(scan, 0, "w", 32);
        set_in_frame(scan, 0, "file_path", 3);
        CHECK_THAT(error_of(scan), Contains("frame 0: \"file_path\" must be a text"));
    }
    SECTION("depth of another kind")
    {
        set_in_frame(scan, 0, "depth_file_path", "depth/0.npy");
        CHECK_THAT(error_of(scan), Contains("frame 0: \"depth_file_path\" is 0.npy"));
    }
    SECTION("a step that is none")
    {
        set_in_frame(scan, 0, "depth_unit_scale_factor", 0);
        CHECK_THAT(error_of(scan), Contains("\"depth_unit_scale_factor\" must be meters per step"));
    }
    SECTION("stopped")
    {
        TestRun run;
        run.cancel_after(2);
        CHECK_THROWS_AS(read(scan, run), fresco::Canceled);
    }
}

TEST_CASE("the recorder's own world is asked for in vain where the file does not tell it", "[scan.nerfstudio]")
{
    const TinyScan scan(Value::Map{{"camera_model", "OPENCV"}});
    const auto text = fresco::read_text_file(scan.file());
    CHECK_THROWS_WITH(nerfstudio::parse_transforms(text, scan.file(), {nerfstudio::World::original, 1, 0, {}}),
                      Contains("applied_transform\" is missing, so the recorder's own world is not known"));
    CHECK_NOTHROW(nerfstudio::parse_transforms(text, scan.file(), {nerfstudio::World::saved, 1, 0, {}}));
}

TEST_CASE("damage to a recording gives an error or what can be used", "[scan.nerfstudio]")
{
    const TinyScan scan(Value::Map{{"camera_model", "OPENCV"}, {"k1", 0}, {"applied_scale", 1.5}});
    const Value first = scan.json().at("frames").as_list().at(0);
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.nerfstudio", scan.path(), scan.images, scan.folder.path() / "out",
                                  {{scan.file(), 200, 200},
                                   {scan.path() / first.at("file_path").as_string()},
                                   {scan.path() / first.at("depth_file_path").as_string()}},
                                  Value::Map{{"world", "original"}});
}
