#include "layout_test.h"
#include "tum.h"

namespace
{

// Cut behind a line, a list is one of a shorter recording.
const LayoutUnderTest layout{
    .type = "layout.tum",
    .write = write_tum,
    .color = "rgb/1305031102.133000.png",
    .depth = "depth/1305031102.137000.png",
    .pose_source = ".txt:",
    .damaged = {"rgb.txt", "depth.txt", "groundtruth.txt"},
    .options =
        [](const Frames& frames, const fs::path&)
    {
        const auto& k = frames.frames[0].color.intrinsics;
        return Value::Map{{"intrinsics", Value::List{k.fx, k.fy, k.cx - 0.5, k.cy - 0.5}}, {"depth_unit_m", 0.001}};
    },
    .third = "rgb 1305031102.166000 2",
    .files_read = 3 + 2 * 3};

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("pictures and poses find each other by time", "[layout.tum]")
{
    const auto pictures = [](const std::vector<double>& times)
    {
        std::vector<tum::StampedPicture> list;
        for (const double time : times)
            list.push_back({time, "p/" + to_json(time) + ".png", "l:" + std::to_string(list.size() + 1)});
        return list;
    };
    std::vector<tum::StampedPose> poses;
    for (const double time : {1.0, 2.0, 3.0, 5.0})
        poses.push_back({time, {{}, {time, 0, 0}}, "g"});
    // 1.1 and 1.2 want the same depth picture: the nearer one has it. 4 has no pose near, 9 nothing at all.
    const auto found = tum::associate(pictures({1.1, 1.2, 2.4, 4.0, 9.0}), pictures({1.19, 2.0, 4.1}), poses, 0.5, "/scan");
    REQUIRE(found.views.size() == 2);
    CHECK(found.without_depth == 2);
    CHECK(found.without_pose == 1);
    CHECK(found.views[0].color == "/scan/p/1.2.png");
    CHECK(found.views[0].depth == "/scan/p/1.19.png");
    CHECK(found.views[0].number == 1);
    CHECK(found.views[0].world_from_camera.translation.x == 1);
    CHECK(found.views[1].depth == "/scan/p/2.0.png");
    CHECK(found.views[1].world_from_camera.translation.x == 2);
    // The depth picture at 4.1 is another's: no gap would make it that of 9.
    CHECK(found.depth_gap_s == 0);
    CHECK(found.pose_gap_s == Approx(1));
    CHECK_THROWS_WITH(tum::associate(pictures({1.0}), pictures({3.0, 4.0}), poses, 0.5, "/scan"),
                      Contains("within max_gap_s (0.5 s): the nearest depth picture is 2.0 s away; l:1 begins at 1.0, ends at "
                               "1.0; l:1 begins at 3.0, ends at 4.0"));
}

TEST_CASE("warnings count pictures without a partner, naming the gap and its option, and pictures that no list names",
          "[layout.tum]")
{
    const WrittenRecording recording(layout);
    TestRun whole;
    recording.read(whole);
    CHECK(std::ranges::none_of(whole.messages, [](const auto& text) { return text.starts_with("warning"); }));
    // The second picture, at 0.133 s, is between two poses.
    recording.write("groundtruth.txt", "1305031102.0970 0 0 0 0 0 0 1\n1305031102.1730 0 0 0 0 0 0 1\n");
    fs::copy(recording.path / layout.color, recording.path / "rgb/1305031109.000000.png");
    TestRun run;
    CHECK(recording.read(run).frames->frames.size() == 2);
    const auto told = [&](const std::string& text)
    { return std::ranges::any_of(run.messages, [&](const auto& message) { return message.find(text) != std::string::npos; }); };
    CHECK(
        told("warning: 0 color pictures have no depth picture and 1 no pose within max_gap_s (0.02 s): the nearest pose is 0.037 "
             "s away; set max_gap_s"));
    CHECK(told("warning: rgb.txt does not list 1 of the pictures in its folder, first"));
    CHECK(told("rgb/1305031109.000000.png; they are not used"));
}

TEST_CASE("the makers' cameras go by name", "[layout.tum]")
{
    const auto first = tum::recording_camera("auto", {}, {}, "/data/rgbd_dataset_freiburg1_desk/");
    CHECK(first.intrinsics == Intrinsics{640, 480, 517.3, 516.5, 319.1, 255.8});
    CHECK(first.lens == recordings::Lens{.k1 = 0.2624, .k2 = -0.9531, .k3 = 1.1633, .p1 = -0.0054, .p2 = 0.0026});
    CHECK(tum::recording_camera("freiburg2", {}, {}, "/x").lens.k3 == 0.9172);
    CHECK_FALSE(tum::recording_camera("freiburg3", {}, {}, "/data/freiburg1").lens.distorts());
    CHECK(tum::recording_camera("ros_default", {}, {}, "/x").intrinsics.cx == 320);
    CHECK_THROWS_WITH(tum::recording_camera("auto", {}, {}, "/data/desk"), Contains("set option \"camera\""));
    const auto own = tum::recording_camera("freiburg1", {1, 2, 3, 4}, {0.1, 0.2, 0.3, 0.4, 0.5}, "/x");
    CHECK(own.intrinsics == Intrinsics{0, 0, 1, 2, 3.5, 4.5});
    CHECK(own.lens == recordings::Lens{.k1 = 0.1, .k2 = 0.2, .k3 = 0.5, .p1 = 0.3, .p2 = 0.4});
    CHECK_THROWS_WITH(tum::recording_camera("auto", {1, 2}, {}, "/x"), Contains("option \"intrinsics\": 2 numbers"));
    CHECK_THROWS_WITH(tum::recording_camera("freiburg1", {}, {1}, "/x"), Contains("option \"distortion\": 1 numbers"));
}

TEST_CASE("a lens is undone, and pictures for another camera are refused", "[layout.tum]")
{
    const WrittenRecording recording(layout);
    const auto result = recording.read(Value::Map{{"distortion", Value::List{0.05, 0.0, 0.0, 0.0, 0.0}}});
    CHECK(result.frames->frames[0].color.intrinsics ==
          recordings::pinhole_without({.k1 = 0.05}, {32, 24, 30.5, 31.25, 15.75, 12.5}, "x"));
    const Value none = Value::List{};
    CHECK_THAT(recording.error(Value::Map{{"intrinsics", none}, {"camera", "freiburg1"}}),
               Contains("the picture is 32x24") && Contains("rgb.txt:3 with the camera freiburg1) is for pictures of 640x480"));
    CHECK_THAT(recording.error(Value::Map{{"intrinsics", none}}), Contains("recording: unknown camera"));
}

TEST_CASE("lists that cannot be used are refused by line", "[layout.tum]")
{
    check_flaws(layout, {{writing("rgb.txt", "1.0 rgb/a.png x\n"), {"rgb.txt:1: 3 words; expected \"timestamp filename\""}},
                         {writing("depth.txt", "2.0 a.png\n1.0 b.png\n"), {"depth.txt:2: the time 1.0 is not later"}},
                         {writing("groundtruth.txt", "# nothing\n"), {"groundtruth.txt: the list is empty"}},
                         {writing("groundtruth.txt", "1 0 0 0 0 0 0 0\n"),
                          {"groundtruth.txt:1: expected a rotation, a quaternion of length 1"}},
                         {removing("depth.txt"), {"depth.txt"}},
                         {removing(layout.color), {"rgb.txt:4 with option intrinsics lists it"}}});
}
