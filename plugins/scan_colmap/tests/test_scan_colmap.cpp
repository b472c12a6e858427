#include "model_views.h"

#include "reader_damage.h"

#include <fresco/error.h>
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

struct TinyProject
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = fresco::testing::tiny_recording(folder.path(), images);

    explicit TinyProject(bool binary) { fresco::testing::write_colmap(frames, path(), binary); }
    fs::path path() const { return folder.path() / "project"; }
    fs::path model(const std::string& name) const { return path() / "sparse/0" / name; }
    std::string text(const std::string& name) const { return fresco::read_text_file(model(name)); }
    void write(const std::string& name, std::string_view text) const { fresco::write_file(model(name), text); }
    /// The first `from` in a file of the model replaced.
    void replace(const std::string& name, std::string_view from, std::string_view to) const
    {
        auto content = text(name);
        const auto at = content.find(from);
        REQUIRE(at != std::string::npos);
        write(name, content.replace(at, from.size(), to));
    }
};

fresco::Frames read(const TinyProject& project, TestRun& run, const Value& options = Value::Map{})
{
    return *fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.colmap", project.path(), project.images,
                                        project.folder.path() / "out", run, options)
                .frames;
}

Value with_depth(const TinyProject& project)
{
    return Value::Map{{"depth", (project.path() / "depth").string()}};
}

std::string error_of(const TinyProject& project, const Value& options = Value::Map{})
{
    return fresco::testing::reading_error([&](TestRun& run) { read(project, run, options); });
}

}  // namespace

TEST_CASE("a reconstruction is read back, text and binary", "[scan.colmap]")
{
    for (const bool binary : {false, true})
    {
        const TinyProject project(binary);
        TestRun run;
        const auto frames = read(project, run, with_depth(project));
        fresco::testing::check_same_recording(frames, project.frames, project.images);
        CHECK(frames.frames[2].name == "view_002");
        CHECK(frames.frames[2].number == 2);
        CHECK(frames.frames[2].sequence == "scan");
        CHECK(run.reported.at("cameras").as_int() == 1);
        CHECK(run.files_read.size() == 2 + 2 * 3);
        CHECK(read(project, run, Value::Map{{"every", 2}}).frames.size() == 2);
    }
}

TEST_CASE("a camera of the world's own axes at (1, 2, 3) is where its file says", "[scan.colmap]")
{
    // A point X is at R X + t in the camera: the identity and t = -(1, 2, 3) put the camera at (1, 2, 3).
    const auto images = colmap::parse_images_text("1 1 0 0 0 -1 -2 -3 5 a b.png\n\n", "images.txt");
    REQUIRE(images.size() == 1);
    CHECK(images[0].world_from_camera.translation == fresco::Vec3d{1, 2, 3});
    CHECK(images[0].world_from_camera.direction({0, 0, 1}) == fresco::Vec3d{0, 0, 1});
    CHECK(images[0].name == "a b.png");
    CHECK(images[0].camera == 5);
}

TEST_CASE("the models' parameters find their places", "[scan.colmap]")
{
    const auto cameras = colmap::parse_cameras_text("1 SIMPLE_PINHOLE 8 6 10 4 3\n2 PINHOLE 8 6 10 11 4 3\n"
                                                    "3 SIMPLE_RADIAL 8 6 10 4 3 0.1\n4 RADIAL 8 6 10 4 3 0.1 0.2\n"
                                                    "5 OPENCV 8 6 10 11 4 3 0.1 0.2 0.3 0.4\n"
                                                    "6 FULL_OPENCV 8 6 10 11 4 3 1 2 3 4 5 6 7 8\n",
                                                    "cameras.txt");
    using fresco::recordings::Lens;
    REQUIRE(cameras.size() == 6);
    CHECK(cameras.at(1).intrinsics == fresco::Intrinsics{8, 6, 10, 10, 4, 3});
    CHECK(cameras.at(2).intrinsics == fresco::Intrinsics{8, 6, 10, 11, 4, 3});
    CHECK_FALSE(cameras.at(2).lens.distorts());
    CHECK(cameras.at(3).lens == Lens{.k1 = 0.1});
    CHECK(cameras.at(4).lens == Lens{.k1 = 0.1, .k2 = 0.2});
    CHECK(cameras.at(5).lens == Lens{.k1 = 0.1, .k2 = 0.2, .p1 = 0.3, .p2 = 0.4});
    CHECK(cameras.at(6).lens == Lens{.k1 = 1, .k2 = 2, .k3 = 5, .k4 = 6, .k5 = 7, .k6 = 8, .p1 = 3, .p2 = 4});
    CHECK(cameras.at(6).source == "cameras.txt:6");
}

TEST_CASE("depth, unit and lens", "[scan.colmap]")
{
    const TinyProject project(false);
    TestRun run;
    const auto without = read(project, run, Value::Map{{"unit_m", 2.0}});
    CHECK(without.frames[1].depth_picture.empty());
    CHECK(without.frames[1].color.world_from_camera.translation.y == Approx(-4.5));
    CHECK_FALSE(run.reported.at("has_depth").as_bool());
    project.replace("cameras.txt", "7 PINHOLE 32 24 30.5 31.25 15.75 12.5", "7 RADIAL 32 24 30.5 15.75 12.5 0.05 0.01");
    auto options = with_depth(project);
    options.set("depth_unit_m", 0.0002);
    const auto frames = read(project, run, options);
    const auto pinhole = fresco::recordings::pinhole_without({.k1 = 0.05, .k2 = 0.01}, {32, 24, 30.5, 30.5, 15.75, 12.5}, "x");
    CHECK(frames.frames[1].color.intrinsics == pinhole);
    CHECK(frames.frames[1].depth.intrinsics == pinhole.scaled_to(16, 12));
    CHECK(frames.frames[1].depth_unit_m == 0.0002);
    CHECK(run.reported.at("undistorted").as_int() == 3);
}

TEST_CASE("the reconstruction is found where tools put it", "[scan.colmap]")
{
    const TinyProject project(true);
    fs::rename(project.path() / "sparse/0", project.path() / "model");
    CHECK_THAT(error_of(project), Contains("no reconstruction of COLMAP") && Contains("sparse/0"));
    for (const char* place : {".", "sparse", "colmap/sparse/0"})
    {
        fs::create_directories(project.path() / place);
        for (const char* name : {"cameras.bin", "images.bin"})
            fs::copy_file(project.path() / "model" / name, project.path() / place / name);
        CHECK(error_of(project) == "no error");
        for (const char* name : {"cameras.bin", "images.bin"})
            fs::remove(project.path() / place / name);
    }
}

TEST_CASE("text that cannot be used is refused by line", "[scan.colmap]")
{
    const TinyProject project(false);
    SECTION("a model that is not read")
    {
        project.replace("cameras.txt", "PINHOLE", "OPENCV_FISHEYE");
        CHECK_THAT(error_of(project), Contains("cameras.txt:3: the camera model \"OPENCV_FISHEYE\" is not read; SIMPLE_PINHOLE"));
    }
    SECTION("another count of parameters")
    {
        project.replace("cameras.txt", "PINHOLE", "OPENCV");
        CHECK_THAT(error_of(project), Contains("cameras.txt:3: 4 parameters where OPENCV has 8"));
    }
    SECTION("counts")
    {
        project.replace("images.txt", "images: 3", "images: 4");
        CHECK_THAT(error_of(project), Contains("images.txt: 3 images where its head counts 4"));
    }
    SECTION("a camera that is missing")
    {
        project.replace("cameras.txt", "\n7 ", "\n8 ");
        CHECK_THAT(error_of(project), Contains("images.txt:3: the camera 7 is not in the file of cameras"));
    }
    SECTION("a camera twice")
    {
        project.write("cameras.txt", "7 SIMPLE_PINHOLE 32 24 30 16 12\n7 SIMPLE_PINHOLE 32 24 30 16 12\n");
        CHECK_THAT(error_of(project), Contains("cameras.txt:2: the camera 7 appears twice"));
    }
    SECTION("lines of points that are none")
    {
        project.replace("images.txt", "1.5 2.5 -1", "1.5 2.5");
        CHECK_THAT(error_of(project), Contains("images.txt:6: expected an image's points"));
    }
    SECTION("a quaternion that is none")
    {
        project.write("images.txt", "1 0.5 0 0 0 1 2 3 7 view 000.png\n\n");
        CHECK_THAT(error_of(project), Contains("images.txt:1: ") && Contains("length 1, this one 0.5"));
    }
    SECTION("too few words")
    {
        project.write("images.txt", "1 1 0 0 0 1 2 3 7\n\n");
        CHECK_THAT(error_of(project), Contains("images.txt:1: 9 words"));
    }
    SECTION("no images")
    {
        project.write("images.txt", "# none\n");
        CHECK_THAT(error_of(project), Contains("images.txt: the reconstruction has no images"));
    }
    SECTION("a size that is none")
    {
        project.replace("cameras.txt", "PINHOLE 32", "PINHOLE 320000");
        CHECK_THAT(error_of(project), Contains("cameras.txt:3: a picture of 320000x24"));
    }
    SECTION("pictures missing")
    {
        fs::remove(project.path() / "images/view 001.png");
        CHECK_THAT(error_of(project), Contains("images/view 001.png"));
    }
}

TEST_CASE("hostile counts are refused before anything is allocated", "[scan.colmap]")
{
    const TinyProject project(true);
    const auto huge = std::string(8, '\xff');
    SECTION("cameras")
    {
        project.write("cameras.bin", huge + project.text("cameras.bin").substr(8));
        CHECK_THAT(error_of(project), Contains("cameras.bin: byte 64: the file ends within a camera"));
    }
    SECTION("images")
    {
        project.write("images.bin", huge + project.text("images.bin").substr(8));
        CHECK_THAT(error_of(project), Contains("images.bin: byte ") && Contains("the file ends within an image"));
    }
    SECTION("points: 24 times this is small again in 64 bits")
    {
        auto bytes = project.text("images.bin");
        const std::size_t at = 8 + 4 + 7 * 8 + 4 + sizeof "view 000.png";
        bytes.replace(at, 8, std::string("\xab\xaa\xaa\xaa\xaa\xaa\xaa\x0a", 8));
        project.write("images.bin", bytes);
        CHECK_THAT(error_of(project), Contains("points of an image do not fit into"));
    }
    SECTION("more than there should be")
    {
        project.write("images.bin", project.text("images.bin") + "x");
        CHECK_THAT(error_of(project), Contains("1 bytes after the expected end"));
    }
    SECTION("a model that is not read")
    {
        auto bytes = project.text("cameras.bin");
        bytes[12] = 5;
        project.write("cameras.bin", bytes);
        CHECK_THAT(error_of(project), Contains("cameras.bin: byte 8: the camera model OPENCV_FISHEYE is not read"));
    }
}

TEST_CASE("what the iPhone of ScanNet++ recorded is read from its three folders", "[scan.colmap]")
{
    const TinyProject project(false);
    const auto iphone = project.folder.path() / "iphone";
    fs::create_directories(iphone);
    fs::rename(project.path() / "sparse/0", iphone / "colmap");
    fs::rename(project.path() / "images", iphone / "rgb");
    fs::rename(project.path() / "depth", iphone / "depth");
    TestRun run;
    const auto read = fresco::testing::run_reader(
        FRESCO_PLUGIN_FILE, "scan.colmap", iphone / "colmap", project.images, project.folder.path() / "out", run,
        Value::Map{{"pictures", (iphone / "rgb").string()}, {"depth", (iphone / "depth").string()}});
    fresco::testing::check_same_recording(*read.frames, project.frames, project.images);
}

TEST_CASE("damage to a reconstruction gives an error or what can be used", "[scan.colmap]")
{
    for (const bool binary : {false, true})
    {
        const TinyProject project(binary);
        const std::string ending = binary ? ".bin" : ".txt";
        std::vector<fresco::testing::DamagedFile> files{{project.model("cameras" + ending), 200, 100},
                                                        {project.model("images" + ending), 200, 100}};
        if (binary)
            for (const char* folder : {"images", "depth"})
                files.push_back({fs::directory_iterator(project.path() / folder)->path()});
        fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.colmap", project.path(), project.images,
                                      project.folder.path() / "out", files, with_depth(project));
    }
}
