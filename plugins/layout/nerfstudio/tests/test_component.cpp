#include "layout_test.h"
#include "transforms.h"

#include <cmath>

namespace
{

/// With other values at the head of the file.
LayoutUnderTest layout_of(const Value& head)
{
    return {.type = "layout.nerfstudio",
            .write =
                [head](const Frames& frames, const fs::path& folder, const ImageIo&)
            {
                write_nerfstudio(frames, folder, head);
                return folder;
            },
            .color = "images/frame_00002.png",
            .depth = "depth/frame_00002.png",
            .pose_source = "transforms.json: frame 1",
            .damaged = {"transforms.json"},
            .third = "images frame_00003 3",
            .files_read = 1 + 2 * 3};
}

const auto layout = layout_of(Value::Map{});

const char* const list = "transforms.json";

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("files are found that are not where they are listed", "[layout.nerfstudio]")
{
    const auto replace_all = [](const WrittenRecording& recording, const std::string& from, const std::string& to)
    {
        auto text = recording.text("transforms.json");
        for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
            text.replace(at, from.size(), to);
        recording.write("transforms.json", text);
    };
    const std::vector<std::tuple<const char*, const char*, const char*>> rules{
        {"images/", "images\\\\", "3 of 6 files were not where the recording names them; 3 were found with / for \\"},
        {"\"images/frame_00001.png", "\"images/frame_00001", "1 were found with another ending"},
        {"images/frame_", "Images/FRAME_", "3 were found with another case"},
        {"images/", "C:\\\\scans\\\\room\\\\images\\\\", "3 were found by the last parts of their paths"},
        {"images/", "/home/a/images/", "3 were found by the last parts of their paths"}};
    for (const auto& [from, to, said] : rules)
    {
        const WrittenRecording recording(layout);
        replace_all(recording, from, to);
        TestRun run;
        check_same_recording(*recording.read(run).frames, recording.frames, recording.images);
        CHECK_THAT(run.messages.front(), Contains(said));
    }
    const WrittenRecording doubled(layout);
    replace_all(doubled, "images/frame_", "Images/frame_");
    fs::create_directory(doubled.path / "IMAGES");
    fs::copy(doubled.path / "images", doubled.path / "IMAGES");
    CHECK_THAT(doubled.error(), Contains("two files could be meant"));
    const WrittenRecording taken(layout);
    replace_all(taken, "images/frame_00002", "other/frame_00001");
    fs::rename(taken.path / "images/frame_00001.png", taken.path / "frame_00001.png");
    replace_all(taken, "images/frame_00001", "frame_00001");
    CHECK_THAT(taken.error(), Contains("frame_00001.png already: correct the names"));
    replace_all(doubled, "Images/frame_", "pictures/x");
    CHECK_THAT(doubled.error(), Contains("3 files are missing"));
}

TEST_CASE("small differences of transforms.json", "[layout.nerfstudio]")
{
    const auto read = [](const auto& edit)
    {
        WrittenRecording recording(layout);
        auto root = recording.json("transforms.json");
        edit(root);
        auto text = to_json(root);
        for (auto at = text.find("\"NaN\""); at != std::string::npos; at = text.find("\"NaN\""))
            text.replace(at, 5, "NaN");
        recording.write("transforms.json", text);
        TestRun run;
        auto frames = recording.read(run).frames->frames;
        return std::pair(frames, run.messages);
    };
    const auto without = [](Value& map, std::string_view key)
    { std::erase_if(map.as_map(), [&](const Value::Entry& entry) { return entry.first == key; }); };
    const Intrinsics camera = WrittenRecording(layout).frames.frames[0].color.intrinsics;
    const auto check_camera = [&](const auto& edit) { CHECK(read(edit).first.at(1).color.intrinsics == camera); };
    check_camera([](Value& root) { root.set("w", "32"); });
    check_camera([](Value& root) { root.set("w", 32.0); });
    check_camera([](Value& root) { root.find("frames")->as_list()[1].find("transform_matrix")->as_list().pop_back(); });
    check_camera([&](Value& root) { without(root, "w"); });
    check_camera(
        [&](Value& root)
        {
            for (const char* key : {"fl_x", "fl_y", "cx", "cy"})
                without(root, key);
            root.set("camera_intrinsics", Value::List{Value::List{camera.fx, 0, camera.cx}, Value::List{0, camera.fy, camera.cy},
                                                      Value::List{0, 0, 1}});
        });
    check_camera(
        [&](Value& root)
        {
            root.set("w", 64);
            root.set("h", 48);
            for (const auto& [key, value] :
                 {std::pair{"fl_x", camera.fx}, {"fl_y", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}})
                root.set(key, 2 * value);
        });
    // As programs write it on Windows, and with one smaller picture.
    const WrittenRecording saved(layout);
    std::string text = "\xEF\xBB\xBF";
    for (const char c : saved.text(list))
        text += c == '\n' ? "\r\n" : std::string(1, c);
    saved.write(list, text);
    check_same_recording(*saved.read().frames, saved.frames, saved.images);
    write_file(saved.path / layout.color, saved.images.encode_png(Raster8(16, 12, 3)));
    const auto mixed = saved.read().frames->frames;
    CHECK((mixed[0].color.intrinsics == camera && mixed[1].color.intrinsics == camera.scaled_to(16, 12)));
    CHECK(mixed[1].depth.intrinsics == mixed[0].depth.intrinsics);

    const auto& [tracked, said] =
        read([](Value& root) { root.find("frames")->as_list()[1].find("transform_matrix")->as_list()[0].as_list()[0] = "NaN"; });
    CHECK(tracked.size() == 2);
    CHECK_THAT(said.back(), Contains("2 frames, 1 left out because their pose is not finite"));
    const auto& [partly, told] = read([&](Value& root) { without(root.find("frames")->as_list()[2], "depth_file_path"); });
    CHECK((partly.size() == 3 && partly[2].depth_picture.empty() && !partly[1].depth_picture.empty()));
    CHECK_THAT(told.back(), Contains("3 frames, 1 of them without depth"));
}

TEST_CASE("camera axes are OpenGL's", "[layout.nerfstudio]")
{
    // The unit matrix looks along -z with y up: OpenCV's y and z are turned.
    TestRun run;
    const auto views = nerfstudio::parse_transforms(
        R"({"w": 8, "h": 6, "camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "./train/r_0",
            "transform_matrix": [[1, 0, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]]}]})",
        "/data/transforms.json", {}, run);
    REQUIRE(views.size() == 1);
    const auto& view = views[0];
    CHECK(view.world_from_camera.direction({0, 0, 1}) == Vec3d{0, 0, -1});
    CHECK(view.world_from_camera.direction({0, 1, 0}) == Vec3d{0, -1, 0});
    CHECK(view.world_from_camera.translation == Vec3d{4, 5, 6});
    // A right angle across 8 pixels; the middle where nothing is said.
    CHECK(view.camera.fx == Approx(4));
    CHECK(view.camera.fy == Approx(4));
    CHECK((view.camera.cx == 4 && view.camera.cy == 3));
    CHECK(view.color == "/data/./train/r_0");
    CHECK(view.depth.empty());
}

TEST_CASE("the recorder's own world is had back", "[layout.nerfstudio]")
{
    // saved = 2 * (y, x, -z): what the file has of a recorder's camera at (5, 6, 7) is at (12, 10, -14).
    const auto made = layout_of(
        Value::Map{{"applied_transform", Value::List{Value::List{0, 1, 0, 0}, Value::List{1, 0, 0, 0}, Value::List{0, 0, -1, 0}}},
                   {"applied_scale", 2.0}});
    const WrittenRecording scan(made);
    scan.set_in_frame(
        list, 0, "transform_matrix",
        Value::List{Value::List{1, 0, 0, 12}, Value::List{0, 1, 0, 10}, Value::List{0, 0, 1, -14}, Value::List{0, 0, 0, 1}});
    TestRun run;
    const auto original = *scan.read(run, Value::Map{{"world", "original"}}).frames;
    const auto& pose = original.frames[0].color.world_from_camera;
    CHECK(pose.translation.x == Approx(5));
    CHECK(pose.translation.y == Approx(6));
    CHECK(pose.translation.z == Approx(7));
    // It looks along the file's -z, which is the recorder's z; the file's x is the recorder's y.
    CHECK(pose.direction({0, 0, 1}) == Vec3d{0, 0, 1});
    CHECK(pose.direction({1, 0, 0}) == Vec3d{0, 1, 0});
    CHECK(scan.read(run).frames->frames[0].color.world_from_camera.translation == Vec3d{12, 10, -14});
    CHECK_THAT(WrittenRecording(layout).error(Value::Map{{"world", "original"}}),
               Contains("applied_transform: is missing, so the recorder's own world is unknown"));
}

TEST_CASE("a frame's own values go before the file's", "[layout.nerfstudio]")
{
    const auto made = layout_of(Value::Map{{"depth_unit_scale_factor", 0.002}});
    const WrittenRecording scan(made);
    scan.set_in_frame(list, 1, "fl_x", 77);
    scan.set_in_frame(list, 2, "camera_angle_x", 2 * std::atan(0.5));
    TestRun run;
    const auto frames = *scan.read(run).frames;
    CHECK(frames.frames[0].color.intrinsics.fx == 30.5);
    CHECK(frames.frames[1].color.intrinsics.fx == 77);
    CHECK(frames.frames[1].depth.intrinsics.fx == 38.5);
    // Half of 32 pixels at a tangent of 0.5; the angle stands for both directions.
    CHECK(frames.frames[2].color.intrinsics.fx == Approx(32));
    CHECK(frames.frames[2].color.intrinsics.fy == Approx(32));
    CHECK(frames.frames[1].depth_unit_m == 0.002);
    CHECK(scan.read(run, Value::Map{{"every", 2}}).frames->frames.size() == 2);
}

TEST_CASE("the file and the pictures may be elsewhere", "[layout.nerfstudio]")
{
    WrittenRecording scan(layout);
    const auto pictures = scan.path;
    const auto file = scan.out() / "elsewhere/transforms_undistorted.json";
    fs::create_directories(file.parent_path());
    fs::rename(scan.path / "transforms.json", file);
    fs::rename(scan.path / "depth", file.parent_path() / "depth");
    scan.path = file;
    CHECK_THAT(scan.error(), Contains("3 files are missing") && Contains("elsewhere/images/frame_00001.png"));
    TestRun run;
    check_same_recording(*scan.read(run, Value::Map{{"pictures", pictures.string()}}).frames, scan.frames, scan.images);
}

TEST_CASE("a lens is undone, a fisheye in nerfstudio's word for it and in instant-ngp's", "[layout.nerfstudio]")
{
    using recordings::Lens;
    const Lens bent{.k1 = 0.08, .p1 = 0.001};
    const Lens fisheye{.k1 = 0.03, .k2 = 0.005, .k3 = 0.001, .k4 = -0.001, .is_fisheye = true};
    const Value::Map fisheye_k{{"k1", fisheye.k1}, {"k2", fisheye.k2}, {"k3", fisheye.k3}, {"k4", fisheye.k4}};
    const auto with = [](Value::Map k, const char* key, const Value& value)
    {
        k.emplace_back(key, value);
        return Value(k);
    };
    for (const auto& [lens, head] :
         {std::pair{bent, with({{"k1", 0.08}, {"k2", 0.0}, {"p1", 0.001}, {"p2", 0}}, "camera_model", "OPENCV")},
          {fisheye, with(fisheye_k, "camera_model", "OPENCV_FISHEYE")},
          {fisheye, with(fisheye_k, "is_fisheye", true)}})
    {
        const auto made = layout_of(head);
        const WrittenRecording scan(made);
        TestRun run;
        const auto frames = *scan.read(run).frames;
        CHECK(run.reported.at("undistorted").as_int() == 3);
        const auto& k = scan.frames.frames[0].color.intrinsics;
        const auto pinhole = recordings::pinhole_without(lens, k, "x");
        CHECK(frames.frames[0].color.intrinsics == pinhole);
        CHECK(load_color(frames.frames[1], &scan.images) ==
              recordings::undistorted(load_color(scan.frames.frames[1], &scan.images), k, lens, pinhole));
        CHECK_NOTHROW(load_depth(frames.frames[1], &scan.images));
    }
}

TEST_CASE("360° pictures are cut", "[layout.nerfstudio]")
{
    // A lens is written beside them by some programs, and means nothing.
    const auto made = layout_of(Value::Map{{"camera_model", "EQUIRECTANGULAR"}, {"k1", 0.1}});
    const WrittenRecording scan(made, [](Frames& frames) { make_panoramas(frames, RawImages()); });
    TestRun run;
    const auto read = scan.read(run);
    check_panoramas(*read.frames, scan.frames, scan.images);
    CHECK(read.frames->frames[17].sequence == "images_down");
    CHECK(read.frames->frames[17].name == "frame_00003");
    CHECK(run.reported.at("panoramas").as_int() == 3);
    CHECK(run.reported.at("undistorted").as_int() == 0);
    const WrittenRecording pinhole(made);
    CHECK_THAT(pinhole.error(), Contains("frame_00001.png: 32x24 pixels; a 360° picture (equirectangular) is twice as wide"));
}

TEST_CASE("masks are read, from where mask_path is relative to", "[layout.nerfstudio]")
{
    const WrittenRecording scan(layout);
    scan.write_mask("masks/a.png", 3, 20);
    scan.set_in_frame(list, 1, "mask_path", "a.png");
    CHECK_THAT(scan.error(), Contains("1 file is missing") && Contains("frame 1 lists it"));
    TestRun run;
    const auto frames = scan.read(run, Value::Map{{"masks", (scan.path / "masks").string()}}).frames->frames;
    CHECK(run.reported.at("masked").as_int() == 1);
    CHECK(frames[0].mask.empty());
    CHECK(load_mask(frames[1]).at(3, 20) == 0);
    CHECK(std::ranges::count(run.files_read, scan.path / "masks/a.png") == 1);
}

TEST_CASE("a split that the file lists is read as such", "[layout.nerfstudio]")
{
    const auto made = layout_of(Value::Map{{"train_filenames", Value::List{"./images/frame_00001.png", "images/frame_00003.png"}},
                                           {"val_filenames", Value::List{"images/frame_00002.png"}},
                                           {"test_filenames", Value::List{"images/frame_00009.png"}}});
    const WrittenRecording scan(made);
    const auto names = [&](const char* split)
    {
        std::vector<std::string> found;
        const auto read = scan.read(Value::Map{{"split", split}});
        for (const auto& frame : read.frames->frames)
            found.push_back(frame.name);
        return found;
    };
    CHECK(names("all").size() == 3);
    CHECK(names("train") == std::vector<std::string>{"frame_00001", "frame_00003"});
    CHECK(names("val") == std::vector<std::string>{"frame_00002"});
    CHECK_THAT(scan.error(Value::Map{{"split", "test"}}),
               Contains("test_filenames: lists images/frame_00009.png, which no frame has"));
    const WrittenRecording without(layout);
    CHECK_THAT(without.error(Value::Map{{"split", "val"}}), Contains("val_filenames: is missing; set split: all"));
}

TEST_CASE("the DSLR folder of ScanNet++ is found, with its masks and test frames", "[layout.nerfstudio]")
{
    const WrittenRecording scan(layout);
    auto json = scan.json(list);
    auto& frames = json.find("frames")->as_list();
    for (std::size_t i = 0; i < 3; ++i)
    {
        const auto name = "frame_0000" + std::to_string(i + 1) + ".png";
        frames[i].set("file_path", name);
        frames[i].set("mask_path", name);
        std::erase_if(frames[i].as_map(), [](const auto& entry) { return entry.first == "depth_file_path"; });
        scan.write_mask("resized_anon_masks/" + name, 0, 0, 5);
    }
    json.set("test_frames", Value::List{frames[2]});
    frames.pop_back();
    fs::create_directories(scan.path / "nerfstudio");
    fs::remove(scan.path / "transforms.json");
    fs::rename(scan.path / "images", scan.path / "resized_images");
    scan.write("nerfstudio/transforms.json", to_json(json));
    const auto train = scan.read(Value::Map{{"split", "train"}}).frames->frames;
    REQUIRE(train.size() == 2);
    CHECK(train[1].color_picture.path == scan.path / "resized_images/frame_00002.png");
    CHECK(std::ranges::count(load_mask(train[1]).values, 0) == 5);
    const auto test = scan.read(Value::Map{{"split", "test"}}).frames->frames;
    REQUIRE(test.size() == 1);
    CHECK(test[0].name == "frame_00003");
}

TEST_CASE("frames without depth are given as such", "[layout.nerfstudio]")
{
    const WrittenRecording scan(layout);
    auto json = scan.json(list);
    for (auto& frame : json.find("frames")->as_list())
        std::erase_if(frame.as_map(), [](const auto& entry) { return entry.first == "depth_file_path"; });
    scan.write("transforms.json", to_json(json));
    TestRun run;
    const auto frames = *scan.read(run).frames;
    CHECK(frames.frames[0].depth_picture.empty());
    CHECK_FALSE(run.reported.at("has_depth").as_bool());
}

TEST_CASE("a file that cannot be used is refused by name", "[layout.nerfstudio]")
{
    using Values = std::vector<std::pair<const char*, Value>>;
    const auto set = [](std::size_t frame, const Values& values)
    {
        return [=](const WrittenRecording& it)
        {
            for (const auto& [key, value] : values)
                it.set_in_frame(list, frame, key, value);
        };
    };
    const std::string angle = "frame 1: camera_angle_x: must be a field of view in radians";
    check_flaws(layout, {{removing("transforms.json"), {"transforms.json"}},
                         {writing("transforms.json", "{\"frames\": []}"), {"transforms.json: frames: must be a list, not empty"}},
                         {set(1, {{"camera_model", "VR180_L"}}), {"transforms.json: frame 1: camera_model: is VR180_L; PINHOLE"}},
                         {set(1, {{"camera_angle_x", 60.0}}), {angle}},
                         {set(1, {{"fl_x", 1e-30}}), {"transforms.json: frame 1: a focal length of 1e-30 pixels"}},
                         {set(1, {{"k4", 0.1}}), {"frame 1: k4: is not 0"}},
                         {set(1, {{"k4", 0.1}, {"is_fisheye", false}, {"camera_model", "FULL_OPENCV"}}), {"no error"}},
                         {set(1, {{"camera_model", "PINHOLE"}}), {"no error"}},
                         {set(1, {{"camera_model", "PINHOLE"}, {"k1", 0.1}}), {"frame 1: camera_model: is PINHOLE, but k1"}},
                         {set(2, {{"transform_matrix", Value::List{Value::List{1, 0, 0, 0}}}}),
                          {"frame 2: transform_matrix: 4 numbers; expected a 4x4 matrix"}},
                         {set(2, {{"transform_matrix", Value::List{Value::List{1, 0, 0, 0}, Value::List{0, 1, 0, 0},
                                                                   Value::List{0, 0, 1, 0}, Value::List{4, 5, 6, 1}}}}),
                          {"frame 2: transform_matrix: expected 0 0 0 1", "it is the last column: write the matrix row by row"}},
                         {set(2, {{"transform_matrix", "x"}}), {"frame 2: transform_matrix: expected a list"}},
                         {set(0, {{"fl_x", "585"}}), {"frame 0: fl_x: expected a number"}},
                         {set(0, {{"w", 32.5}}), {"frame 0: w: expected a whole number of pixels"}},
                         {set(0, {{"depth_file_path", "depth/0.npy"}}), {"frame 0: depth_file_path: is 0.npy"}},
                         {set(0, {{"depth_unit_scale_factor", 0}}), {"depth_unit_scale_factor: must be meters per step"}},
                         {set(0, {{"depth_unit_scale_factor", 1000}}), {"; for steps of a millimeter, 0.001"}}});
}
