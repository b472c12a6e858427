#include "keyframes.h"

#include "reader_run.h"
#include "recording_checks.h"

#include <catch2/catch.hpp>

namespace fs = std::filesystem;
using Catch::Contains;
using fresco::Value;
using fresco::testing::RawImages;
using fresco::testing::TestRun;

namespace
{

/// Writes the tiny recording as Polycam does.
struct TinyCapture
{
    fresco::testing::TemporaryFolder folder;
    RawImages images;
    fresco::Frames frames = fresco::testing::tiny_recording(folder.path(), images);

    TinyCapture() { write("corrected_"); }
    fs::path path() const { return folder.path() / "capture"; }
    fs::path keyframes() const { return path() / "keyframes"; }
    static std::string time(std::size_t i) { return std::to_string(998 + i); }
    fs::path camera(std::size_t i) const { return keyframes() / "corrected_cameras" / (time(i) + ".json"); }

    void write(const std::string& prefix) const
    {
        fs::create_directories(keyframes() / (prefix + "cameras"));
        for (std::size_t i = 0; i < frames.frames.size(); ++i)
        {
            const auto& frame = frames.frames[i];
            const auto& k = frame.color.intrinsics;
            Value camera = Value::Map{{"width", k.width}, {"height", k.height}, {"fx", k.fx},         {"fy", k.fy},
                                      {"cx", k.cx},       {"cy", k.cy},         {"blur_score", 100.5}};
            const auto m = fresco::testing::matrix_of(frame.color.world_from_camera);
            for (std::size_t row = 0; row < 3; ++row)
                for (std::size_t column = 0; column < 4; ++column)
                    camera.set("t_" + std::to_string(row) + std::to_string(column),
                               column == 1 || column == 2 ? -m[4 * row + column] : m[4 * row + column]);
            fresco::write_file(keyframes() / (prefix + "cameras") / (time(i) + ".json"), fresco::to_json(camera));
            fresco::testing::copy_picture(frame.color_picture.path, keyframes() / (prefix + "images") / (time(i) + ".jpg"));
            fresco::testing::copy_picture(frame.depth_picture.path, keyframes() / "depth" / (time(i) + ".png"));
        }
    }
    fresco::testing::ReadScan read(TestRun& run, const Value& options = Value::Map{}) const
    {
        return fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.polycam", path(), images, folder.path() / "out", run,
                                           options);
    }
    std::string error(const Value& options = Value::Map{}) const
    {
        return fresco::testing::error_text(
            [&]
            {
                TestRun run;
                read(run, options);
            });
    }
};

}  // namespace

TEST_CASE("a capture is read back, by time", "[scan.polycam]")
{
    const TinyCapture capture;
    TestRun run;
    const auto result = capture.read(run);
    // 998, 999, 1000: by number, not by letters.
    fresco::testing::check_same_recording(*result.frames, capture.frames, capture.images);
    CHECK(result.frames->frames[2].name == "1000");
    CHECK(result.frames->frames[2].number == 1000);
    CHECK(run.reported.at("corrected").as_bool());
    CHECK(run.files_read.size() == 3 * 3);
    CHECK(capture.read(run, Value::Map{{"every", 2}}).frames->frames[1].number == 1000);
}

TEST_CASE("without corrected cameras ARKit's are taken, with a warning", "[scan.polycam]")
{
    const TinyCapture capture;
    CHECK_THAT(capture.error(Value::Map{{"poses", "recorded"}}),
               Contains("keyframes/cameras: there is no such folder; expected Polycam"));
    capture.write("");
    fs::remove_all(capture.keyframes() / "corrected_images");
    TestRun run;
    CHECK(capture.read(run).frames->frames.size() == 3);
    CHECK_THAT(run.messages.front(), Contains("warning: the export has no corrected cameras"));
    TestRun asked;
    capture.read(asked, Value::Map{{"poses", "recorded"}});
    CHECK(asked.messages.size() == 1);
}

TEST_CASE("frames are brought into the mesh's world", "[scan.polycam]")
{
    const TinyCapture capture;
    CHECK_THAT(capture.error(Value::Map{{"world", "mesh"}}), Contains("mesh_info.json"));
    // y up becomes z up, and 5 m along x; column by column.
    const auto text = R"({"alignmentTransform": [1, 0, 0, 0,  0, 0, 1, 0,  0, -1, 0, 0,  5, 0, 0, 1]})";
    CHECK(polycam::parse_alignment(text, "x").point({1, 2, 3}) == fresco::Vec3d{6, -3, 2});
    fresco::write_file(capture.path() / "mesh_info.json", text);
    TestRun run;
    const auto moved = capture.read(run, Value::Map{{"world", "mesh"}}).frames->frames[0].color.world_from_camera.translation;
    const auto& place = capture.frames.frames[0].color.world_from_camera.translation;
    CHECK(length(moved - fresco::Vec3d{place.x + 5, -place.z, place.y}) < 1e-9);
    fresco::write_file(capture.path() / "mesh_info.json", R"({"alignmentTransform": [1, 2]})");
    CHECK_THAT(capture.error(Value::Map{{"world", "mesh"}}), Contains("mesh_info.json: alignmentTransform: 16 numbers"));
}

TEST_CASE("a capture that cannot be used is refused by name", "[scan.polycam]")
{
    const TinyCapture capture;
    SECTION("a picture missing")
    {
        fs::remove(capture.keyframes() / "depth/999.png");
        CHECK_THAT(capture.error(), Contains("1 file is missing") && Contains("depth/999.png"));
    }
    SECTION("no cameras")
    {
        for (const std::size_t i : {0U, 1U, 2U})
            fs::remove(capture.camera(i));
        CHECK_THAT(capture.error(), Contains("corrected_cameras: no cameras"));
    }
    SECTION("a value missing")
    {
        fresco::write_file(capture.camera(1),
                           R"({"width": 32, "height": 24, "fx": 30, "fy": 30, "cx": 16, "cy": 12, "t_00": 1})");
        CHECK_THAT(capture.error(), Contains("999.json") && Contains("\"t_01\" is missing"));
    }
    SECTION("no JSON")
    {
        fresco::write_file(capture.camera(1), "{");
        CHECK_THAT(capture.error(), Contains("999.json"));
    }
}

TEST_CASE("damage to a camera gives an error or frames that can be used", "[scan.polycam]")
{
    const TinyCapture capture;
    TestRun run(1);
    const auto parse = [&]
    {
        auto views = polycam::list_keyframes(capture.path(), polycam::keyframe_folders(capture.path(), false));
        for (auto& view : views)
            polycam::parse_camera(fresco::read_text_file(view.source), fs::path(view.source), view);
        return fresco::recordings::registered_frames(views, capture.images, capture.folder.path(), run);
    };
    const auto counts = fresco::testing::damage_file(capture.camera(0), [&](bool) { fresco::testing::check_usable(parse()); });
    CHECK(counts.cuts_refused == 200);
    CHECK(counts.flips_refused > 150);
}
