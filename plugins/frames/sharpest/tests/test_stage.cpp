#include "catch.h"
#include "plugin_under_test.h"
#include "raw_images.h"
#include "selection.h"

#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/images/sharpness.h>
#include <fresco/npy.h>
#include <fresco/testing_scenes.h>

namespace fs = std::filesystem;
using fresco::testing::TestRun;
namespace testing = fresco::testing;

namespace
{

MeasuredFrame measured(const std::string& sequence, double value)
{
    return {sequence, "frame", value};
}

/// Frames whose pictures are NPY files: even gray for `false`, a checkerboard for `true`.
fresco::Frames made_frames(const fs::path& folder, const std::vector<bool>& sharp)
{
    fresco::Frames frames;
    for (std::size_t i = 0; i < sharp.size(); ++i)
    {
        fresco::Frame frame = testing::frame("frame-" + std::to_string(i), testing::camera(64, 48, 50), static_cast<long>(i));
        testing::set_color_picture(frame, folder,
                                   sharp[i] ? testing::checkerboard(64, 48, 4, 50, 200) : fresco::Raster8(64, 48, 3, 128));
        frame.color_picture.hash = fresco::file_hash(frame.color_picture.path);
        frames.frames.push_back(frame);
    }
    return frames;
}

fresco::Frames run_sharpest(const fresco::Frames& input, fresco::Value options, TestRun& run)
{
    if (!options.find("measure"))
        options.set("measure", "laplacian_variance");
    return *testing::output_of<fresco::Frames>("frames.sharpest", "frames", options,
                                               {{"frames", std::make_shared<fresco::Frames>(input)}}, run,
                                               {{"image_io", std::make_shared<testing::RawImages>()}});
}

}  // namespace

TEST_CASE("the sharpest of each window is kept, and windows end with the sequence", "[frames.sharpest]")
{
    const std::vector<MeasuredFrame> frames{measured("a", 5), measured("a", 9), measured("a", 9), measured("a", 1),
                                            measured("b", 2), measured("b", 3), measured("b", 4)};
    const auto s = select_frames(frames, {.min_sharpness = 2, .window_count = 3, .max_frames = 0});
    // Windows: a {5 9 9}, a {1}, b {2 3 4}.
    CHECK(s.kept == std::vector<std::size_t>{1, 6});
    CHECK(s.blurred == 1);  // The threshold itself passes.
    CHECK(s.less_sharp == 4);
}

TEST_CASE("max_frames spreads over the whole recording", "[frames.sharpest]")
{
    std::vector<MeasuredFrame> frames;
    for (const double value : {1, 2, 9, 4, 5, 6, 7, 8, 3, 1})
        frames.push_back(measured("a", value));
    const auto s = select_frames(frames, {.min_sharpness = 0, .window_count = 1, .max_frames = 3});
    // Stretches of 3, 3 and 4 frames.
    CHECK(s.kept == std::vector<std::size_t>{2, 5, 7});
    CHECK(s.beyond_limit == 7);
    CHECK(select_frames(frames, {.min_sharpness = 0, .window_count = 1, .max_frames = 10}).kept.size() == 10);
}

TEST_CASE("when all are blurred the error names thresholds that would pass", "[frames.sharpest]")
{
    CHECK_THROWS_WITH(select_frames({measured("a", 20), measured("b", 40.56), measured("c", 30)},
                                    {.min_sharpness = 150, .window_count = 1, .max_frames = 0}),
                      Contains("none of the 3 frames passes min_sharpness 150.0") && Contains("b/frame, has 40.5") &&
                          Contains("min_sharpness: 30.0"));
    CHECK_THROWS_WITH(select_frames({}, {.min_sharpness = 0, .window_count = 1, .max_frames = 0}), Contains("no frames"));
}

TEST_CASE("every frame goes to exactly one side, in order", "[frames.sharpest]")
{
    const fresco::testing::TemporaryFolder folder;
    const auto input = made_frames(folder.path(), {true, true, false, true, true, true, true, true});
    std::string message;
    const auto numbers = [&](int every, bool held_out)
    {
        TestRun run;
        std::vector<long> result;
        for (const fresco::Frame& frame :
             run_sharpest(input, fresco::Value::Map{{"hold_out_every", every}, {"held_out", held_out}}, run).frames)
            result.push_back(frame.number);
        message = run.messages.at(0);
        return result;
    };
    CHECK(numbers(3, true) == std::vector<long>{1, 5});
    CHECK(message == "2 of 8 frames kept; dropped: 1 blurred, 0 beside a sharper one, 0 beyond max_frames; 5 not held out");
    CHECK(numbers(3, false) == std::vector<long>{0, 3, 4, 6, 7});
    CHECK(message == "5 of 8 frames kept; dropped: 1 blurred, 0 beside a sharper one, 0 beyond max_frames; 2 held out");
    CHECK_THROWS_WITH(numbers(1, false), Contains("7 of 7 frames would be held out"));
    CHECK_THROWS_WITH(numbers(20, false), Contains("0 of 7 frames would be held out"));
    CHECK_THROWS_WITH(numbers(0, true), Contains("set hold_out_every, too"));
}

TEST_CASE_METHOD(testing::StageTest, "the stage keeps sharp frames and reports", "[frames.sharpest]")
{
    const auto input = made_frames(folder.path(), {true, false, true, true, false});
    const auto kept = run_sharpest(input, fresco::Value::Map{}, run);
    REQUIRE(kept.frames.size() == 3);
    CHECK(kept.frames[1].name == "frame-2");
    CHECK(kept.frames[1].color_picture.hash == input.frames[2].color_picture.hash);
    const fresco::Value& judged = run.reported.at("judged_frames");
    CHECK(judged.at("names").as_list().at(4).as_string() == "seq-01/frame-4");
    CHECK(judged.at("values").as_list().at(4).as_double() == 0);
    CHECK(judged.at("values").as_list().at(0).as_double() > judged.at("least").as_double());
}

TEST_CASE_METHOD(testing::StageTest, "the stage refuses what it cannot use", "[frames.sharpest]")
{
    const auto input = made_frames(folder.path(), {false, false, true});
    CHECK_THROWS_WITH(run_sharpest(made_frames(folder.path(), {false, false}), fresco::Value::Map{}, run),
                      Contains("none of the 2"));
    fresco::write_npy(input.frames[2].color_picture.path, fresco::Raster8(64, 48, 3, 1));
    TestRun changed;
    CHECK_THROWS_WITH(run_sharpest(input, fresco::Value::Map{}, changed), Contains("frame-2"));
}
