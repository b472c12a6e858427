#include "posed_frames.h"

#include "reader_damage.h"
#include "shared_data.h"

#include <fresco/error.h>
#include <fresco/hash.h>
#include <fresco/mesh.h>
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

const char* const pose_text = "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n";

/// Two sequences of two frames: color 64x48, depth 32x24.
struct TinyScan
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;

    TinyScan()
    {
        for (const char* sequence : {"seq-02", "seq-10"})
            for (const char* name : {"frame-000002", "frame-000010"})
                add_frame(sequence, name);
        write("color-intrinsics.txt", "50 0 32\n0 51 24\n0 0 1\n");
        write("depth-intrinsics.txt", "25 0 16\n0 26 12\n0 0 1\n");
        write("color_from_depth.txt", "1 0 0 -0.026\n0 1 0 0\n0 0 1 0.002\n0 0 0 1\n");
        fresco::Mesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}};
        fresco::write_file(path() / "mesh.ply", fresco::to_ply(mesh));
    }

    const fs::path& path() const { return folder.path(); }
    void write(const std::string& name, std::string_view text) const { fresco::write_file(path() / name, text); }
    void add_frame(const std::string& sequence, const std::string& name) const
    {
        fs::create_directories(path() / sequence);
        const std::string stem = sequence + "/" + name;
        fresco::write_file(path() / (stem + ".color.jpg"), images.encode_jpeg(fresco::Raster8(64, 48, 3, 7), 95));
        fresco::write_file(path() / (stem + ".depth.png"), images.encode_png(fresco::Raster16(32, 24, 1, 1500)));
        write(stem + ".pose.txt", pose_text);
    }
};

struct Result : fresco::testing::ReadScan
{
    fresco::testing::TemporaryFolder out;
};

void run_scan(const fs::path& path, const fresco::Value& options, TestRun& run, Result& result, const RawImages& images = {})
{
    static_cast<fresco::testing::ReadScan&>(result) =
        fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.seven_scenes", path, images, result.out.path(), run, options);
}

std::string error_of(const TinyScan& scan, const fresco::Value& options = fresco::Value::Map{})
{
    return fresco::testing::error_text(
        [&]
        {
            TestRun run;
            Result result;
            run_scan(scan.path(), options, run, result, scan.images);
        });
}

}  // namespace

TEST_CASE("a scan becomes frames of two cameras in recorded order", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun run;
    Result result;
    run_scan(scan.path(), fresco::Value::Map{}, run, result);
    const auto& frames = result.frames->frames;
    REQUIRE(frames.size() == 4);
    CHECK(frames[0].sequence == "seq-02");
    CHECK(frames[3].sequence == "seq-10");
    CHECK(frames[2].name == "frame-000002");
    CHECK(frames[3].number == 10);
    CHECK(frames[0].color.intrinsics == fresco::Intrinsics{64, 48, 50, 51, 32, 24});
    CHECK(frames[0].depth.intrinsics == fresco::Intrinsics{32, 24, 25, 26, 16, 12});
    // The pose turns by 90 degrees about z and is the depth camera's. The color camera's center, X_color = 0, lies at
    // X_depth = (0.026, 0, -0.002), in the world at R X + t = (5, 6 + 0.026, 7 - 0.002).
    CHECK(frames[0].depth.world_from_camera.translation == fresco::Vec3d{5, 6, 7});
    const auto center = frames[0].color.world_from_camera.translation;
    CHECK(center.x == Approx(5));
    CHECK(center.y == Approx(6.026));
    CHECK(center.z == Approx(6.998));
    CHECK(frames[1].color_picture.hash == fresco::file_hash(scan.path() / "seq-02/frame-000010.color.jpg"));
    CHECK(fresco::load_color(frames[0], &scan.images).at(5, 5) == 7);
    CHECK(fresco::load_depth(frames[0], &scan.images).at(5, 5) == Approx(1.5f));
    CHECK(result.mesh->triangles.size() == 1);
    CHECK(run.reported.at("frames").as_int() == 4);
    CHECK(run.messages == std::vector<std::string>{"4 frames of 2 sequences"});
}

TEST_CASE("every file that was read is recorded", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun run;
    Result result;
    run_scan(scan.path(), fresco::Value::Map{}, run, result);
    CHECK(run.files_read.size() == 4 * 3 + 3 + 1);
    for (const char* file : {"seq-10/frame-000002.pose.txt", "color_from_depth.txt", "mesh.ply"})
        CHECK(std::count(run.files_read.begin(), run.files_read.end(), scan.path() / file) == 1);
    CHECK(run.folders_read ==
          std::vector<fs::path>{scan.path() / "seq-*", scan.path() / "seq-02/frame-*", scan.path() / "seq-10/frame-*"});
    // A calibration that is not there may come; one that an option gives may not.
    fs::remove(scan.path() / "color-intrinsics.txt");
    fs::remove(scan.path() / "color_from_depth.txt");
    TestRun uncalibrated;
    run_scan(scan.path(),
             fresco::Value::Map{{"color_intrinsics", fresco::Value::List{50, 51, 32, 24}}, {"sequences", fresco::Value::List{2}}},
             uncalibrated, result);
    CHECK(uncalibrated.folders_read ==
          std::vector<fs::path>{scan.path() / "seq-*", scan.path() / "seq-02/frame-*", scan.path() / "color_from_depth.txt"});
}

TEST_CASE("sequences and every choose frames", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun run;
    Result result;
    run_scan(scan.path(), fresco::Value::Map{{"sequences", fresco::Value::List{10}}, {"every", 2}}, run, result);
    REQUIRE(result.frames->frames.size() == 1);
    CHECK(result.frames->frames[0].sequence == "seq-10");
    CHECK(result.frames->frames[0].number == 2);
    CHECK_THAT(error_of(scan, fresco::Value::Map{{"sequences", fresco::Value::List{3}}}),
               Contains("no sequence 3; there are 2, 10"));
}

TEST_CASE("results do not depend on the thread count", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun one(1), two(2);
    Result a, b;
    run_scan(scan.path(), fresco::Value::Map{}, one, a);
    run_scan(scan.path(), fresco::Value::Map{}, two, b);
    CHECK(fresco::read_text_file(a.out.path() / "frames/frames.json") ==
          fresco::read_text_file(b.out.path() / "frames/frames.json"));
}

TEST_CASE("options go before calibration files", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun run;
    Result result;
    const fresco::Value::List k{fresco::Value(40.0), fresco::Value(41.0), fresco::Value(31.0), fresco::Value(23.0)};
    run_scan(scan.path(), fresco::Value::Map{{"color_intrinsics", k}, {"pixel_center", "integer"}, {"depth_unit_m", 0.0002}}, run,
             result);
    CHECK(result.frames->frames[0].color.intrinsics == fresco::Intrinsics{64, 48, 40, 41, 31.5, 23.5});
    CHECK(result.frames->frames[0].depth_unit_m == 0.0002);
    CHECK_THAT(error_of(scan, fresco::Value::Map{{"color_from_depth", fresco::Value::List{1, 0}}}),
               Contains("option color_from_depth"));
    CHECK_THAT(error_of(scan, fresco::Value::Map{{"color_intrinsics", fresco::Value::List{1, 2, 3}}}),
               Contains("option color_intrinsics: 3 numbers"));
}

TEST_CASE("without calibration 640x480 is assumed with warnings and another size is refused", "[scan.seven_scenes]")
{
    const TinyScan scan;
    for (const char* file : {"color-intrinsics.txt", "depth-intrinsics.txt", "color_from_depth.txt"})
        fs::remove(scan.path() / file);
    CHECK_THAT(error_of(scan), Contains("64x48") && Contains("only 640x480 can be assumed"));

    fs::remove_all(scan.path() / "seq-02");
    fs::remove_all(scan.path() / "seq-10");
    scan.add_frame("seq-01", "frame-000000");
    const auto stem = scan.path() / "seq-01";
    fresco::write_file(stem / "frame-000000.color.jpg", scan.images.encode_jpeg(fresco::Raster8(640, 480, 3, 7), 95));
    fresco::write_file(stem / "frame-000000.depth.png", scan.images.encode_png(fresco::Raster16(640, 480, 1, 1500)));
    TestRun run;
    Result result;
    run_scan(scan.path(), fresco::Value::Map{}, run, result);
    CHECK(result.frames->frames[0].color.intrinsics == fresco::Intrinsics{640, 480, 585, 585, 320, 240});
    CHECK(result.frames->frames[0].color == result.frames->frames[0].depth);
    CHECK(std::count_if(run.messages.begin(), run.messages.end(),
                        [](const std::string& line) { return line.starts_with("warning: "); }) == 3);
}

TEST_CASE("a scan that cannot be used is refused by name", "[scan.seven_scenes]")
{
    const TinyScan scan;
    SECTION("no sequences")
    {
        fs::remove_all(scan.path() / "seq-02");
        fs::remove_all(scan.path() / "seq-10");
        CHECK_THAT(error_of(scan), Contains("no sequences; expected folders seq-01"));
    }
    SECTION("no frames")
    {
        fs::remove_all(scan.path() / "seq-02");
        fs::remove_all(scan.path() / "seq-10");
        fs::create_directory(scan.path() / "seq-01");
        CHECK_THAT(error_of(scan), Contains("hold no frames"));
    }
    SECTION("partners missing")
    {
        fs::remove(scan.path() / "seq-02/frame-000002.depth.png");
        fs::remove(scan.path() / "seq-10/frame-000010.pose.txt");
        CHECK_THAT(error_of(scan), Contains("2 files are missing") && Contains("seq-02/frame-000002.depth.png") &&
                                       Contains("seq-10/frame-000010.pose.txt"));
    }
    SECTION("two color pictures")
    {
        fs::copy_file(scan.path() / "seq-02/frame-000002.color.jpg", scan.path() / "seq-02/frame-000002.color.png");
        CHECK_THAT(error_of(scan), Contains("another color picture"));
    }
    SECTION("a pose with NaN")
    {
        scan.write("seq-02/frame-000010.pose.txt", "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scan), Contains("frame-000010.pose.txt") && Contains("not finite"));
    }
    SECTION("a pose that scales")
    {
        scan.write("seq-02/frame-000010.pose.txt", "1.1 0 0 0\n0 1.1 0 0\n0 0 1.1 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scan), Contains("frame-000010.pose.txt") && Contains("not a rotation"));
    }
    SECTION("a pose that cannot be parsed")
    {
        scan.write("seq-02/frame-000010.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 one 0\n0 0 0 1\n");
        CHECK_THAT(error_of(scan), Contains("frame-000010.pose.txt:3: \"one\" is not a number"));
    }
    SECTION("intrinsics of another form")
    {
        scan.write("depth-intrinsics.txt", "25 0 16\n0 26 12\n");
        CHECK_THAT(error_of(scan), Contains("depth-intrinsics.txt: 2 rows; expected a 3x3"));
    }
    SECTION("intrinsics for another size")
    {
        scan.write("color-intrinsics.txt", "500 0 320\n0 500 240\n0 0 1\n");
        CHECK_THAT(error_of(scan), Contains("color-intrinsics.txt") && Contains("outside") && Contains("64x48"));
    }
    SECTION("a picture of another size")
    {
        fresco::write_file(scan.path() / "seq-10/frame-000002.color.jpg",
                           scan.images.encode_jpeg(fresco::Raster8(48, 64, 3, 7), 95));
        CHECK_THAT(error_of(scan), Contains("seq-10/frame-000002.color.jpg: the picture is 48x64") && Contains("64x48"));
    }
    SECTION("a depth picture that is cut")
    {
        const auto file = scan.path() / "seq-10/frame-000002.depth.png";
        auto bytes = fresco::read_file(file);
        bytes.pop_back();
        fresco::write_file(file, bytes);
        CHECK_THAT(error_of(scan), Contains("seq-10/frame-000002.depth.png: cut"));
    }
    SECTION("a depth picture of 8 bits, or in colors")
    {
        const auto file = scan.path() / "seq-10/frame-000002.depth.png";
        const auto size = scan.images.header(file);
        fresco::write_file(file, scan.images.encode_png(fresco::Raster8(size.width, size.height, 1, 7)));
        CHECK_THAT(error_of(scan), Contains("frame-000002.depth.png: expected a depth picture") && Contains("8 bits"));
        fresco::write_file(file, scan.images.encode_png(fresco::Raster16(size.width, size.height, 3, 7)));
        CHECK_THAT(error_of(scan), Contains("expected a depth picture") && Contains("colors"));
    }
    SECTION("no mesh")
    {
        fs::remove(scan.path() / "mesh.ply");
        CHECK_THAT(error_of(scan), Contains("mesh.ply: no mesh"));
    }
}

TEST_CASE("missing inputs are of the kind that ends with exit code 3, and a run can be stopped", "[scan.seven_scenes]")
{
    const TinyScan scan;
    TestRun run;
    run.cancel_after(2);
    Result result;
    CHECK_THROWS_AS(run_scan(scan.path(), fresco::Value::Map{}, run, result), fresco::Canceled);
    fs::remove(scan.path() / "mesh.ply");
    TestRun again;
    CHECK_THROWS_AS(run_scan(scan.path(), fresco::Value::Map{}, again, result), fresco::MissingInput);
}

TEST_CASE("the kitchen has 125 frames of two cameras 2.6 cm apart", "[scan.seven_scenes]")
{
    const auto path = shared_data("kitchen", "scan.seven_scenes on the kitchen");
    if (path.empty())
        return;
    const auto scan = list_scan(path, {}, 1);
    CHECK(scan.frames.size() == 125);
    CHECK(scan.frames.back().number == 992);
    const auto calibration = read_calibration(path, {});
    CHECK(calibration.guesses.empty());
    CHECK(depth_intrinsics(calibration, 640, 480) == fresco::Intrinsics{640, 480, 585, 585, 320, 240});

    const auto codec = fs::path(FRESCO_PLUGIN_FILE).parent_path() / "image_opencv.so";
    if (!fs::exists(codec))
    {
        std::cout << "SKIPPED reading the kitchen's pictures: image_opencv is not built" << std::endl;
        return;
    }
    const auto images = fresco::testing::make_from_plugin(codec, "image.opencv");
    TestRun run;
    const auto frames = posed_frames(scan, calibration, dynamic_cast<fresco::ImageIo&>(*images), run);
    for (const auto& frame : frames.frames)
    {
        const auto apart = frame.color.world_from_camera.translation - frame.depth.world_from_camera.translation;
        CHECK(fresco::length(apart) == Approx(std::sqrt(0.026 * 0.026 + 0.002 * 0.002)).epsilon(1e-4));
    }
}

TEST_CASE("damage to a scan gives an error or what can be used", "[scan.seven_scenes]")
{
    const TinyScan scan;
    const fresco::testing::TemporaryFolder out;
    const auto path = scan.path();
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.seven_scenes", path, scan.images, out.path(),
                                  {{path / "color-intrinsics.txt", 180, 200},
                                   {path / "depth-intrinsics.txt", 180, 200},
                                   {path / "color_from_depth.txt", 180, 200},
                                   {path / "seq-02/frame-000010.pose.txt", 180, 200},
                                   {path / "seq-02/frame-000002.color.jpg"},
                                   {path / "seq-10/frame-000010.depth.png"},
                                   {path / "mesh.ply", 200, 100}});
}
