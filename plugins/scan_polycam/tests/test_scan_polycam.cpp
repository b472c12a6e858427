#include "keyframes.h"

#include "reader_damage.h"

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

    TinyCapture() { fresco::testing::write_polycam(frames, path()); }
    fs::path path() const { return folder.path() / "capture"; }
    fs::path keyframes() const { return path() / "keyframes"; }
    fs::path camera(std::size_t i) const { return keyframes() / "corrected_cameras" / (std::to_string(998 + i) + ".json"); }

    fresco::testing::ReadScan read(TestRun& run, const Value& options = Value::Map{}) const
    {
        return fresco::testing::run_reader(FRESCO_PLUGIN_FILE, "scan.polycam", path(), images, folder.path() / "out", run,
                                           options);
    }
    std::string error(const Value& options = Value::Map{}) const
    {
        return fresco::testing::reading_error([&](TestRun& run) { read(run, options); });
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
    CHECK_THAT(capture.error(Value::Map{{"poses", "recorded"}}), Contains("keyframes/cameras: no such folder; expected Polycam"));
    fresco::testing::write_polycam(capture.frames, capture.path(), "");
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

TEST_CASE("damage to a capture gives an error or what can be used", "[scan.polycam]")
{
    const TinyCapture capture;
    fresco::write_file(capture.path() / "mesh_info.json",
                       R"({"alignmentTransform": [1, 0, 0, 0,  0, 0, 1, 0,  0, -1, 0, 0,  5, 0, 0, 1]})");
    fresco::testing::check_damage(FRESCO_PLUGIN_FILE, "scan.polycam", capture.path(), capture.images,
                                  capture.folder.path() / "out",
                                  {{capture.camera(0), 200, 150},
                                   {capture.path() / "mesh_info.json", 200, 150},
                                   {capture.keyframes() / "corrected_images/999.jpg"},
                                   {capture.keyframes() / "depth/1000.png"}},
                                  Value::Map{{"world", "mesh"}});
}
