#include "keyframes.h"
#include "layout_test.h"

namespace
{

const LayoutUnderTest layout{.type = "layout.polycam",
                             .write = write_polycam,
                             .color = "keyframes/corrected_images/999.jpg",
                             .depth = "keyframes/depth/999.png",
                             .pose_source = "corrected_cameras/999.json",
                             .damaged = {"keyframes/corrected_cameras/998.json"},
                             // By number, not by letters.
                             .may_lack_depth = true,
                             .third = "keyframes 1000 1000",
                             .files_read = 3 * 3};

const char* const camera_file = "keyframes/corrected_cameras/999.json";

// y up becomes z up, and 5 m along x; column by column.
const char* const alignment = R"({"alignmentTransform": [1, 0, 0, 0,  0, 0, 1, 0,  0, -1, 0, 0,  5, 0, 0, 1]})";

}  // namespace

std::vector<LayoutUnderTest> forms()
{
    return {layout};
}

TEST_CASE("small differences of captures", "[layout.polycam]")
{
    const WrittenRecording capture(layout);
    const auto said = [&]
    {
        TestRun run;
        const auto frames = capture.read(run).frames->frames;
        return std::to_string(frames.at(0).color.intrinsics.width) + ": " + run.messages.back();
    };
    capture.replace(camera_file, "\"width\"", "\"wide\"");
    CHECK_THAT(said(), Contains("32: 3 frames"));
    capture.remove("keyframes/depth/999.png");
    CHECK_THAT(said(), Contains("3 frames, 1 of them without depth"));
    capture.remove(camera_file);
    CHECK_THAT(said(), Contains("2 frames; left out 1 without a corrected camera"));
    // Polycam may correct only a part of what was recorded.
    for (const char* time : {"998", "999", "1000", "1001", "1002"})
        capture.write(fs::path("keyframes/images") / (std::string(time) + ".jpg"), "");
    CHECK_THAT(said(), Contains("2 frames; left out 3 without a corrected camera"));
    capture.remove("keyframes/depth");
    CHECK_THAT(capture.error(), Contains("2 files are missing"));
}

TEST_CASE("without corrected cameras ARKit's are taken, with a warning", "[layout.polycam]")
{
    const WrittenRecording capture(layout);
    const auto keyframes = capture.path / "keyframes";
    fs::rename(keyframes / "corrected_images", keyframes / "images");
    CHECK_THAT(capture.error(), Contains("keyframes/cameras: no such folder; expected Polycam"));
    fs::rename(keyframes / "corrected_cameras", keyframes / "cameras");
    TestRun run;
    CHECK(capture.read(run).frames->frames.size() == 3);
    CHECK_THAT(run.messages.front(), Contains("warning: the export has no corrected cameras"));
}

TEST_CASE("frames are brought into the mesh's world", "[layout.polycam]")
{
    const WrittenRecording capture(layout);
    CHECK_THAT(capture.error(Value::Map{{"world", "mesh"}}), Contains("mesh_info.json"));
    CHECK(polycam::parse_alignment(alignment, "x").point({1, 2, 3}) == Vec3d{6, -3, 2});
    capture.write("mesh_info.json", alignment);
    TestRun run;
    const auto moved = capture.read(run, Value::Map{{"world", "mesh"}}).frames->frames[0].color.world_from_camera.translation;
    const auto& place = capture.frames.frames[0].color.world_from_camera.translation;
    CHECK(length(moved - Vec3d{place.x + 5, -place.z, place.y}) < 1e-9);
    capture.write("mesh_info.json", R"({"alignmentTransform": [1, 2]})");
    CHECK_THAT(capture.error(Value::Map{{"world", "mesh"}}),
               Contains("mesh_info.json: alignmentTransform: expected a list of 16"));
}

TEST_CASE("a capture that cannot be used is refused by name", "[layout.polycam]")
{
    check_flaws(layout,
                {{[](const auto& it)
                  {
                      it.remove("keyframes/corrected_cameras");
                      fs::create_directory(it.path / "keyframes/corrected_cameras");
                  },
                  {"holds no views; each needs keyframes/corrected_cameras/N.json"}},
                 {writing(camera_file, R"({"width": 32, "height": 24, "fx": 30, "fy": 30, "cx": 16, "cy": 12, "t_00": 1})"),
                  {"999.json", "t_01: missing"}},
                 {writing(camera_file, "{"), {"999.json"}}});
    const WrittenRecording capture(layout);
    capture.write("mesh_info.json", alignment);
    check_damage(capture, {"mesh_info.json"}, Value::Map{{"world", "mesh"}});
}
