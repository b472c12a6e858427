#include "layout_test.h"
#include "model.h"

namespace
{

LayoutUnderTest layout_of(bool binary)
{
    const std::string ending = binary ? ".bin" : ".txt";
    return {.type = "layout.colmap",
            .write =
                [binary](const Frames& frames, const fs::path& folder, const ImageIo&)
            {
                write_colmap(frames, folder, binary);
                return folder;
            },
            .color = "images/view 001.png",
            .depth = "depth/view 001.png",
            .pose_source = "images" + ending + ":",
            .damaged = {"sparse/0/cameras" + ending, "sparse/0/images" + ending},
            .options =
                [](const Frames&, const fs::path& path) {
                    return Value::Map{{"depth", (path / "depth").string()}};
                },
            .third = "scan view_002 2",
            .files_read = 2 + 2 * 3};
}

const auto text_layout = layout_of(false), binary_layout = layout_of(true);
const fs::path cameras_file = "sparse/0/cameras.txt", images_file = "sparse/0/images.txt";

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {text_layout, binary_layout};
}

TEST_CASE("the models' parameters find their places", "[layout.colmap]")
{
    const auto cameras =
        colmap::parse_cameras_text("1 SIMPLE_PINHOLE 8 6 10 4 3\n2 PINHOLE 8 6 10 11 4 3\n"
                                   "3 SIMPLE_RADIAL 8 6 10 4 3 0.1\n4 RADIAL 8 6 10 4 3 0.1 0.2\n"
                                   "5 OPENCV 8 6 10 11 4 3 0.1 0.2 0.3 0.4\n"
                                   "6 FULL_OPENCV 8 6 10 11 4 3 1 2 3 4 5 6 7 8\n"
                                   "7 OPENCV_FISHEYE 8 6 10 11 4 3 1 2 3 4\n8 SIMPLE_RADIAL_FISHEYE 8 6 10 4 3 1\n"
                                   "9 RADIAL_FISHEYE 8 6 10 4 3 1 2\n10 SIMPLE_FISHEYE 8 6 10 4 3\n11 FISHEYE 8 6 10 11 4 3\n"
                                   "12 EQUIRECTANGULAR 8 4 8 4\n13 SPHERICAL 8 4 8 4\n",
                                   "cameras.txt");
    using recordings::Lens;
    REQUIRE(cameras.size() == 13);
    CHECK(cameras.at(1).intrinsics == Intrinsics{8, 6, 10, 10, 4, 3});
    CHECK(cameras.at(2).intrinsics == Intrinsics{8, 6, 10, 11, 4, 3});
    CHECK_FALSE(cameras.at(2).lens.distorts());
    CHECK(cameras.at(3).lens == Lens{.k1 = 0.1});
    CHECK(cameras.at(4).lens == Lens{.k1 = 0.1, .k2 = 0.2});
    CHECK(cameras.at(5).lens == Lens{.k1 = 0.1, .k2 = 0.2, .p1 = 0.3, .p2 = 0.4});
    CHECK(cameras.at(6).lens == Lens{.k1 = 1, .k2 = 2, .k3 = 5, .k4 = 6, .k5 = 7, .k6 = 8, .p1 = 3, .p2 = 4});
    CHECK(cameras.at(7).lens == Lens{.k1 = 1, .k2 = 2, .k3 = 3, .k4 = 4, .is_fisheye = true});
    CHECK(cameras.at(8).lens == Lens{.k1 = 1, .is_fisheye = true});
    CHECK(cameras.at(9).lens == Lens{.k1 = 1, .k2 = 2, .is_fisheye = true});
    CHECK(cameras.at(10).lens == Lens{.is_fisheye = true});
    CHECK(cameras.at(11).intrinsics == Intrinsics{8, 6, 10, 11, 4, 3});
    CHECK(cameras.at(11).lens == Lens{.is_fisheye = true});
    CHECK_FALSE(cameras.at(11).is_panorama);
    for (const int panorama : {12, 13})
    {
        CHECK(cameras.at(panorama).is_panorama);
        CHECK(cameras.at(panorama).intrinsics == Intrinsics{.width = 8, .height = 4});
    }
    CHECK(cameras.at(6).source == "cameras.txt:6");
}

TEST_CASE("depth and lens", "[layout.colmap]")
{
    auto without_options = text_layout;
    without_options.options = {};
    const WrittenRecording plain(without_options);
    TestRun run;
    const auto without = plain.read(run).frames->frames;
    CHECK(without[1].depth_picture.empty());
    CHECK_FALSE(run.reported.at("has_depth").as_bool());
    const WrittenRecording project(text_layout);
    project.replace(cameras_file, "7 PINHOLE 32 24 30.5 31.25 15.75 12.5", "7 RADIAL 32 24 30.5 15.75 12.5 0.05 0.01");
    const auto frames = project.read(run).frames->frames;
    const auto pinhole = recordings::pinhole_without({.k1 = 0.05, .k2 = 0.01}, {32, 24, 30.5, 30.5, 15.75, 12.5}, "x");
    CHECK(frames[1].color.intrinsics == pinhole);
    CHECK(frames[1].depth.intrinsics == pinhole.scaled_to(16, 12));
    CHECK(run.reported.at("undistorted").as_int() == 3);
}

TEST_CASE("360° pictures are cut, text and binary", "[layout.colmap]")
{
    for (const auto* layout : {&text_layout, &binary_layout})
    {
        const WrittenRecording project(*layout, [](Frames& frames) { make_panoramas(frames, RawImages()); });
        TestRun run;
        const auto read = project.read(run);
        check_panoramas(*read.frames, project.frames, project.images);
        CHECK(read.frames->frames[4].sequence == "scan_right");
        CHECK(read.frames->frames[4].name == "view_001");
        CHECK(read.frames->frames[4].number == 1);
        CHECK(run.reported.at("panoramas").as_int() == 3);
        CHECK(project.read(Value::Map{{"every", 2}}).frames->frames.size() == 12);
    }
    const WrittenRecording project(text_layout, [](Frames& frames) { make_panoramas(frames, RawImages()); });
    project.replace(cameras_file, " 64 32 64.0 32.0", " 64 32 128 64");
    CHECK_THAT(project.error(), Contains("cameras.txt:3: the parameter w is 128; expected the size of the picture, 64x32"));
}

TEST_CASE("the reconstruction is found where tools put it", "[layout.colmap]")
{
    const WrittenRecording project(binary_layout);
    fs::rename(project.path / "sparse/0", project.path / "model");
    CHECK_THAT(project.error(), Contains("no COLMAP reconstruction") && Contains("sparse/0"));
    for (const char* place : {".", "sparse", "colmap/sparse/0", "colmap", "colmap_sparse/0", "colmap_sparse"})
    {
        fs::create_directories((project.path / place).parent_path());
        fs::copy(project.path / "model", project.path / place);
        CHECK(project.error() == "no error");
        for (const char* name : {"cameras.bin", "images.bin"})
            fs::remove(project.path / place / name);
    }
}

TEST_CASE("a reconstruction without its pictures says where to put them, or what to set", "[layout.colmap]")
{
    const WrittenRecording project(text_layout);
    fs::rename(project.path / "images", project.path / "photos");
    CHECK_THAT(project.error(Value::Map{}),
               Contains("there is no folder images (or rgb, resized_images)") && Contains("set option \"pictures\""));
    CHECK(project.read(Value::Map{{"pictures", (project.path / "photos").string()}}).frames->frames.size() == 3);
    // ScanNet++'s iPhone recordings have this folder.
    fs::rename(project.path / "photos", project.path / "rgb");
    check_same_recording(*project.read().frames, project.frames, project.images);
}

TEST_CASE("masks have COLMAP's names, or those of the pictures", "[layout.colmap]")
{
    const WrittenRecording project(text_layout);
    project.write_mask("masks/view 000.png", 0, 0, 0);
    project.write_mask("masks/view 001.png.png");
    project.write_mask("masks/view 002.png.png", 0, 0, 0);
    TestRun run;
    const auto frames = project.read(run, Value::Map{{"masks", (project.path / "masks").string()}}).frames->frames;
    CHECK(run.reported.at("masked").as_int() == 1);
    CHECK(load_mask(frames[1]).at(0, 0) == 0);
}

TEST_CASE("text that cannot be used is refused by line", "[layout.colmap]")
{
    check_flaws(text_layout,
                {{replacing(cameras_file, "PINHOLE", "THIN_PRISM_FISHEYE"),
                  {"cameras.txt:3: camera model \"THIN_PRISM_FISHEYE\" is not supported; expected SIMPLE_PINHOLE"}},
                 {replacing(cameras_file, "PINHOLE", "OPENCV"), {"cameras.txt:3: 4 parameters; OPENCV has 8"}},
                 {replacing(images_file, "images: 3", "images: 4"), {"images.txt: 3 images; its header declares 4"}},
                 {replacing(cameras_file, "\n7 ", "\n8 "), {"images.txt:3: the camera 7 is not in the cameras file"}},
                 {writing(cameras_file, "7 SIMPLE_PINHOLE 32 24 30 16 12\n7 SIMPLE_PINHOLE 32 24 30 16 12\n"),
                  {"cameras.txt:2: the camera 7 appears twice"}},
                 {replacing(images_file, "1.5 2.5 -1", "1.5 2.5"), {"images.txt:6: expected an image's points"}},
                 {writing(images_file, "1 0.5 0 0 0 1 2 3 7 view 000.png\n\n"), {"images.txt:1: ", "its length is 0.5"}},
                 {writing(images_file, "1 1 0 0 0 1 2 3 7\n\n"), {"images.txt:1: 9 words"}},
                 {writing(images_file, "# none\n"), {"images.txt: the reconstruction has no images"}},
                 {replacing(cameras_file, "PINHOLE 32", "PINHOLE 320000"), {"cameras.txt:3: a picture of 320000x24"}}});
}

TEST_CASE("hostile counts are refused before anything is allocated", "[layout.colmap]")
{
    const std::string cameras = "sparse/0/cameras.bin", images = "sparse/0/images.bin";
    const auto set = [](const std::string& file, std::size_t at, const std::string& bytes)
    { return [=](const WrittenRecording& it) { it.write(file, it.text(file).replace(at, bytes.size(), bytes)); }; };
    const auto huge = std::string(8, '\xff');
    // 24 times this count of points is small again in 64 bits.
    const std::string wrapping("\xab\xaa\xaa\xaa\xaa\xaa\xaa\x0a", 8);
    check_flaws(binary_layout,
                {{set(cameras, 0, huge), {"cameras.bin: byte 64: the file ends inside a camera"}},
                 {set(images, 0, huge), {"images.bin: byte ", "the file ends inside an image"}},
                 {set(images, 8 + 4 + 7 * 8 + 4 + sizeof "view 000.png", wrapping), {"points do not fit into"}},
                 {[&](const auto& it) { it.write(images, it.text(images) + "x"); }, {"1 bytes after the expected end"}},
                 {set(cameras, 12, "\x07"), {"cameras.bin: byte 8: camera model FOV is not supported"}}});
}
