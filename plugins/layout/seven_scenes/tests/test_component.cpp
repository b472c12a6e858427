#include "layout_test.h"

#include <fresco/files_io.h>

#include <algorithm>

namespace
{

/// The layout of 7-Scenes, with the names and numbers of the frames.
fs::path write_seven_scenes(const Frames& frames, const fs::path& folder)
{
    for (const auto& frame : frames.frames)
    {
        const auto stem = (folder / frame.sequence / frame.name).string();
        copy_picture(frame.color_picture.path, stem + ".color.png");
        copy_picture(frame.depth_picture.path, stem + ".depth.png");
        write_file(stem + ".pose.txt", rows_of(matrix_of(frame.depth.world_from_camera), 4));
    }
    const auto& first = frames.frames.front();
    for (const auto& [name, k] : {std::pair{"color", first.color.intrinsics}, std::pair{"depth", first.depth.intrinsics}})
        write_file(folder / (std::string(name) + "-intrinsics.txt"), rows_of({k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1}, 3));
    const auto color_from_depth = first.color.world_from_camera.inverse() * first.depth.world_from_camera;
    write_file(folder / "color_from_depth.txt", rows_of(matrix_of(color_from_depth), 4));
    write_mesh(folder / "mesh.ply");
    return folder;
}

const LayoutUnderTest layout{.type = "layout.seven_scenes",
                             .write = [](const Frames& frames, const fs::path& folder, const ImageIo&)
                             { return write_seven_scenes(frames, folder); },
                             .color = "seq-01/frame-000001.color.png",
                             .depth = "seq-01/frame-000001.depth.png",
                             .pose_source = "seq-01/frame-000001.pose.txt",
                             .damaged = {"color-intrinsics.txt", "depth-intrinsics.txt", "color_from_depth.txt",
                                         "seq-01/frame-000001.pose.txt", "mesh.ply"},
                             .has_depth_camera = true,
                             .third = "seq-01 frame-000002 2",
                             .mesh_faces = 1,
                             .files_read = 3 * 3 + 3 + 1};

/// The frames 0 and 1 in seq-02, frame 10 in seq-10.
void spread(Frames& frames)
{
    for (auto& frame : frames.frames)
        frame.sequence = "seq-02";
    frames.frames[2].sequence = "seq-10";
    frames.frames[2].name = "frame-000010";
}

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("every name that was looked for is recorded", "[layout.seven_scenes]")
{
    const WrittenRecording scan(layout, spread);
    // Calibration and a mesh that are not there may come.
    for (const char* file : {"color_from_depth.txt", "mesh.ply"})
        scan.remove(file);
    std::vector<fs::path> names{scan.path / "seq-*"};
    for (const char* kind : {"color.png", "color.jpg", "color.jpeg", "depth.png", "pose.txt"})
        names.push_back(scan.path / "seq-02" / (std::string("frame-*.") + kind));
    names.push_back(scan.path / "color_from_depth.txt");
    names.push_back(scan.path / "mesh.ply");
    TestRun run;
    CHECK(scan.read(run, Value::Map{{"sequences", Value::List{2}}}).mesh == nullptr);
    CHECK(run.folders_read == names);
}

TEST_CASE("sequences and every choose frames", "[layout.seven_scenes]")
{
    const WrittenRecording scan(layout, spread);
    // Every sequence starts over.
    const auto frames = scan.read(Value::Map{{"every", 2}}).frames->frames;
    REQUIRE(frames.size() == 2);
    CHECK(frames[1].sequence == "seq-10");
    CHECK(frames[1].number == 10);
    CHECK(scan.read(Value::Map{{"sequences", Value::List{10}}}).frames->frames.size() == 1);
    CHECK_THAT(scan.error(Value::Map{{"sequences", Value::List{3}}}), Contains("no sequence 3; found 2, 10"));
}

TEST_CASE("frames in the folder itself are its only sequence", "[layout.seven_scenes]")
{
    const WrittenRecording scan(layout);
    const auto whole = scan.read().frames->frames;
    for (const auto& entry : fs::directory_iterator(scan.path / "seq-01"))
        fs::copy(entry.path(), scan.path / entry.path().filename());
    scan.remove("seq-01");
    const auto flat = scan.read().frames->frames;
    CHECK(flat.at(0).sequence == "seq-01");
    CHECK(flat[0].name == whole[0].name);
    CHECK(flat[0].color.world_from_camera.translation == whole[0].color.world_from_camera.translation);
}

TEST_CASE("without calibration 640x480 is assumed with warnings and another size is refused", "[layout.seven_scenes]")
{
    const WrittenRecording scan(layout);
    for (const char* file : {"color-intrinsics.txt", "depth-intrinsics.txt", "color_from_depth.txt"})
        scan.remove(file);
    CHECK_THAT(scan.error(), Contains("32x24") && Contains("the default calibration is for 640x480"));

    for (int i = 0; i < 3; ++i)
    {
        const auto stem = (scan.path / ("seq-01/frame-00000" + std::to_string(i))).string();
        write_file(stem + ".color.png", scan.images.encode_png(Raster8(640, 480, 3, 7)));
        write_file(stem + ".depth.png", scan.images.encode_png(Raster16(640, 480, 1, 1500)));
    }
    TestRun run;
    const auto frame = scan.read(run).frames->frames[0];
    CHECK(frame.color.intrinsics == Intrinsics{640, 480, 585, 585, 320, 240});
    CHECK(frame.color == frame.depth);
    CHECK(std::count_if(run.messages.begin(), run.messages.end(),
                        [](const std::string& line) { return line.starts_with("warning: "); }) == 3);
}

TEST_CASE("a scan that cannot be used is refused by name", "[layout.seven_scenes]")
{
    const auto copied = [](const char* to)
    { return [=](const WrittenRecording& it) { it.write(to, it.text("seq-01/frame-000001.color.png")); }; };
    const char* const pose = "seq-01/frame-000001.pose.txt";
    check_flaws(layout,
                {{removing("seq-01"), {"no sequences; expected folders seq-01"}},
                 {[](const auto& it)
                  {
                      it.remove("seq-01");
                      fs::create_directory(it.path / "seq-01");
                  },
                  {"holds no views; each needs seq-N/frame-N.color.png (or .jpg), .depth.png and .pose.txt"}},
                 {[&](const auto& it)
                  {
                      it.remove("seq-01/frame-000000.depth.png");
                      it.remove(pose);
                  },
                  {"2 files are missing", "seq-01/frame-000000.depth.png", pose}},
                 {copied("seq-01/frame-000001.color.jpg"), {"a second file with this number"}},
                 {[&](const auto& it) { fs::rename(it.path / pose, it.path / "seq-01/frame-01.pose.txt"); },
                  {"frame-01.pose.txt: a second name for number 1, the first is frame-000001"}},
                 {writing(pose, "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"), {pose, "not finite"}},
                 {writing(pose, "1 0 0 0\n0 1 0 0\n0 0 one 0\n0 0 0 1\n"), {std::string(pose) + ":3: \"one\" is not a number"}},
                 {writing("depth-intrinsics.txt", "25 0 16\n0 26 12\n"), {"depth-intrinsics.txt: 2 rows; expected a 3x3"}}});
}
