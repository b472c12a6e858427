#include "catch.h"

#include <fresco/frames.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

namespace
{

std::vector<long> numbers(const std::filesystem::path& folder)
{
    std::vector<long> result;
    const auto frames = fresco::Frames::load({folder, {}});
    for (const fresco::Frame& frame : frames->frames)
        result.push_back(frame.number);
    return result;
}

void run(int frames_count, const fresco::Value& options, const std::filesystem::path& folder)
{
    auto frames = std::make_shared<fresco::Frames>();
    for (int i = 0; i < frames_count; ++i)
        frames->frames.push_back(fresco::testing::frame("f" + std::to_string(i), fresco::testing::camera(4, 4, 4), i));
    fresco::testing::TestRun context;
    fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "frames.hold_out", options, {{"frames", frames}}, folder, context);
}

}  // namespace

TEST_CASE("Every frame goes to exactly one side, in order")
{
    const fresco::testing::TemporaryFolder folder;
    run(7, fresco::Value::Map{{"every_count", 3}, {"first_count", 1}}, folder.path());
    CHECK(numbers(folder.path() / "held_out") == std::vector<long>{1, 4});
    CHECK(numbers(folder.path() / "training") == std::vector<long>{0, 2, 3, 5, 6});
}

TEST_CASE("Nothing to hold out is an error that says what to change")
{
    const fresco::testing::TemporaryFolder folder;
    CHECK_THROWS_WITH(run(3, fresco::Value::Map{{"first_count", 5}}, folder.path()), Catch::Contains("first_count"));
}
