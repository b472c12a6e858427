#include "folder_text.h"
#include "layout_test.h"

namespace
{

fs::path write_folder(const Frames& frames, const fs::path& folder, bool one_list)
{
    std::string list = "# camera to world\n";
    for (std::size_t i = 0; i < frames.frames.size(); ++i)
    {
        const auto& frame = frames.frames[i];
        // In the order of numbers, not of letters.
        const std::string name = "v" + std::to_string(8 + i);
        copy_picture(frame.color_picture.path, folder / "images" / (name + ".png"));
        copy_picture(frame.depth_picture.path, folder / "depth" / (name + ".png"));
        const auto m = matrix_of(frame.color.world_from_camera);
        list += joined(i == 1 ? m : std::vector<double>(m.begin(), m.end() - 4)) + "\n";
        if (!one_list)
        {
            fs::create_directories(folder / "poses");
            write_file(folder / "poses" / (name + ".txt"), rows_of(m, 4));
        }
    }
    if (one_list)
        write_file(folder / "poses.txt", list);
    const auto& k = frames.frames.front().color.intrinsics;
    write_file(folder / "K.txt",
               one_list ? joined({k.fx, k.fy, k.cx, k.cy}) + "\n" : rows_of({k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1}, 3));
    write_mesh(folder / "mesh.ply");
    return folder;
}

LayoutUnderTest layout_of(bool one_list)
{
    return {.type = "layout.folder",
            .write = [one_list](const Frames& frames, const fs::path& folder, const ImageIo&)
            { return write_folder(frames, folder, one_list); },
            .color = "images/v9.png",
            .depth = "depth/v9.png",
            .pose_source = one_list ? "poses.txt:3" : "poses/v9.txt",
            .damaged = {one_list ? "poses.txt" : "poses/v9.txt", "K.txt", "mesh.ply"},
            .third = "scan v10 10",
            .mesh_faces = 1};
}

const auto list_layout = layout_of(true), file_layout = layout_of(false);

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {list_layout, file_layout};
}

TEST_CASE("one recording in any convention is the same", "[layout.folder]")
{
    const WrittenRecording recording(list_layout);
    std::string gl, inverse, inverse_gl;
    for (const auto& frame : recording.frames.frames)
    {
        const auto& pose = frame.color.world_from_camera;
        gl += joined(opengl_matrix_of(pose)) + "\n";
        inverse += joined(matrix_of(pose.inverse())) + "\n";
        // The rows y and z of what takes the world into the camera are turned.
        auto m = matrix_of(pose.inverse());
        for (std::size_t entry = 4; entry < 12; ++entry)
            m[entry] = -m[entry];
        inverse_gl += joined(m) + "\n";
    }
    const std::vector<std::tuple<std::string, const char*, const char*>> forms{{gl, "opengl", "world_from_camera"},
                                                                               {inverse, "opencv", "camera_from_world"},
                                                                               {inverse_gl, "opengl", "camera_from_world"}};
    for (const auto& [text, axes, direction] : forms)
    {
        recording.write("poses.txt", text);
        const auto found = recording.read(Value::Map{{"axes", axes}, {"direction", direction}});
        check_same_recording(*found.frames, recording.frames, recording.images);
    }
}

TEST_CASE("pixel centers, lens and a mask", "[layout.folder]")
{
    const WrittenRecording recording(list_layout);
    recording.write("K.txt", "30.5 31.25 15.25 12\n");
    for (const char* file : {"masks/v8.png", "masks/v9.png", "masks/v10.png"})
        recording.write_mask(file, 9, 4);
    TestRun run;
    const auto frames = recording.read(run, Value::Map{{"pixel_center", "integer"}}).frames->frames;
    CHECK(frames[0].color.intrinsics == recording.frames.frames[0].color.intrinsics);
    CHECK(run.reported.at("masked").as_int() == 3);
    CHECK(load_mask(frames[1]).at(9, 4) == 0);
    const auto bent = recording.read(Value::Map{{"distortion", Value::List{0.05, 0.0, 0.001, 0.0, 0.0}}}).frames->frames;
    CHECK(bent[0].color.intrinsics ==
          recordings::pinhole_without({.k1 = 0.05, .p1 = 0.001}, {32, 24, 30.5, 31.25, 15.25, 12}, "x"));
}

TEST_CASE("360° pictures are cut", "[layout.folder]")
{
    const WrittenRecording recording(file_layout, [](Frames& frames) { make_panoramas(frames, RawImages()); });
    recording.write("K.txt", "equirectangular\n");
    check_panoramas(*recording.read().frames, recording.frames, recording.images);
    CHECK_THAT(recording.error(Value::Map{{"distortion", Value::List{0.05, 0.0, 0.0, 0.0, 0.0}}}),
               Contains("K.txt: 360° pictures have no lens to undo"));
    recording.write("K.txt", "equirectangular");
    CHECK_THAT(recording.error(), Contains("K.txt"));
}

TEST_CASE("a folder without depth or mesh is read, and a view whose tracking was lost is left out", "[layout.folder]")
{
    const WrittenRecording recording(file_layout);
    recording.remove("depth");
    recording.remove("mesh.ply");
    fs::rename(recording.path / "images", recording.path / "rgb");
    recording.write("poses/v9.txt", "nan nan nan nan\nnan nan nan nan\nnan nan nan nan\n0 0 0 1\n");
    TestRun run;
    const auto found = recording.read(run);
    CHECK(found.frames->frames.size() == 2);
    CHECK(found.frames->frames[0].depth_picture.empty());
    CHECK(found.mesh == nullptr);
    CHECK(run.reported.at("poses_not_tracked").as_int() == 1);
}

TEST_CASE("folders that cannot be used are refused by file and line", "[layout.folder]")
{
    check_flaws(list_layout, {{writing("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n"), {"poses.txt: 1 poses for 3 pictures"}},
                              {writing("poses.txt", "# x\n\n1 2 3 0 0 0 1\n"),
                               {"poses.txt:3: 7 words; expected the 12 or 16 numbers of a 3x4 or 4x4 matrix"}},
                              {removing("poses.txt"), {"there are no poses; expected poses.txt, or poses/NAME.txt"}},
                              {removing("images"), {"there is no folder images"}},
                              {removing("K.txt"), {"the camera's matrix is missing; expected", "K.txt"}},
                              {writing("K.txt", "1 2\n3 4\n"), {"K.txt:1: 2 numbers"}},
                              {writing("K.txt", "1 2 3\n"), {"K.txt:1: 3 numbers"}}});
    check_flaws(list_layout, {{[](WrittenRecording&) {}, {"\"distortion\": expected 5 finite numbers"}}},
                Value::Map{{"distortion", Value::List{1.0}}});
}
