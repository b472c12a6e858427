#include "checkpoint.h"
#include "studio.h"

#include <fresco/error.h>

#include <algorithm>

using namespace fakes;

namespace
{

struct Resumed
{
    bool canceled = false;
    std::size_t steps_before = 0;
    std::size_t steps = 0;  ///< Of both runs.
    std::vector<std::vector<std::byte>> bytes;
};

/// Canceled at the `calls`-th time that the stage asks, and run again to its end.
Resumed canceled_and_resumed(Studio& studio, const Value& options, int calls)
{
    Resumed result;
    testing::TestRun run;
    run.cancel_after(calls);
    try
    {
        studio.paint(run, options);
    }
    catch (const Canceled&)
    {
        result.canceled = true;
    }
    result.steps_before = run.metrics["loss"].size();
    if (!result.canceled)
        run.metrics["loss"].clear();
    run.cancel_after(1000);
    result.bytes = bytes_in(studio.paint(run, options));
    result.steps = run.metrics["loss"].size();
    return result;
}

}  // namespace

TEST_CASE("a run that is canceled, or killed, goes on to the same bytes")
{
    Studio studio;
    for (const char* mode : {"visible", "dense"})
    {
        auto options = Studio::options(mean_losses, {{"epochs", 2}, {"lambda_r", 0.01}, {"checkpoint_steps", 0}});
        options.set("optimizer", Value::Map{{"type", "optimizer.adam"}, {"mode", mode}});
        testing::TestRun whole;
        const auto expected = bytes_in(studio.paint(whole, options));

        testing::TestRun interrupted;
        interrupted.cancel_after(3 + 14);  // 3 batches of views, then in the middle of a visit
        CHECK_THROWS_AS(studio.paint(interrupted, options), Canceled);
        CHECK(interrupted.metrics.at("loss").size() == 13);
        CHECK((bytes_in(studio.paint(interrupted, options)) == expected));
        CHECK(interrupted.metrics.at("loss").size() == 36);
        REQUIRE_FALSE(interrupted.messages.empty());
        CHECK(interrupted.messages.back() == "going on after step 13 of 36");

        // With periodic checkpoints too.
        options.set("checkpoint_steps", 10);
        testing::TestRun killed;
        killed.cancel_after(3 + 21);
        CHECK_THROWS_AS(studio.paint(killed, options), Canceled);
        CHECK((bytes_in(studio.paint(killed, options)) == expected));
    }
}

TEST_CASE("a loss that asks within a step loses nothing when the run is canceled")
{
    Studio studio;
    const auto options = Studio::options(Value::Map{{"it", Value::Map{{"type", "asking"}}}}, {{"max_steps", 9}});
    testing::TestRun whole;
    const auto expected = bytes_in(studio.paint(whole, options));
    int gone_on = 0;
    for (int calls = 1; calls < 24; ++calls)
    {
        CAPTURE(calls);
        const Resumed resumed = canceled_and_resumed(studio, options, calls);
        CHECK((resumed.bytes == expected));
        CHECK(resumed.steps == 9);
        gone_on += resumed.canceled && resumed.steps_before > 0;
    }
    CHECK(gone_on >= 8);
}

TEST_CASE("what a run that ends without warning would lose is kept from time to time")
{
    Studio studio;
    auto options = Studio::options(Value::Map{{"it", Value::Map{{"type", "breaking"}}}},
                                   {{"max_steps", 12}, {"checkpoint_steps", 0}, {"checkpoint_seconds", 0.0}});
    testing::TestRun nothing;
    CHECK_THROWS_WITH(studio.paint(nothing, options), Catch::Contains("broken"));
    CHECK(std::filesystem::is_empty(nothing.checkpoint_folder()));

    options.set("checkpoint_seconds", 1e-9);
    testing::TestRun killed;
    CHECK_THROWS_WITH(studio.paint(killed, options), Catch::Contains("broken"));
    const auto kept = fresco::optimize::Checkpoint::read(killed.checkpoint_folder() / "interrupted.safetensors");
    REQUIRE(kept);
    CHECK(kept->step >= 1);
    CHECK(kept->step < 9);
}

TEST_CASE("a checkpoint that cannot take its place ends the run")
{
    Studio studio;
    testing::TestRun run;
    std::filesystem::create_directories(run.checkpoint_folder() / "earlier.safetensors" / "in_the_way");
    const auto options = Studio::options(mean_losses, {{"max_steps", 9}, {"checkpoint_steps", 2}});
    CHECK_THROWS_WITH(studio.paint(run, options), Catch::Contains("cannot be renamed to earlier.safetensors"));
}

TEST_CASE("a flipped bit in a checkpoint is named and changes nothing")
{
    Studio studio;
    const auto options = Studio::options(mean_losses, {{"epochs", 1}, {"checkpoint_steps", 0}});
    testing::TestRun whole;
    const auto expected = bytes_in(studio.paint(whole, options));
    testing::TestRun run;
    run.cancel_after(3 + 8);
    CHECK_THROWS_AS(studio.paint(run, options), Canceled);
    const auto file = run.checkpoint_folder() / "interrupted.safetensors";
    auto bytes = read_file(file);
    bytes[bytes.size() - bytes.size() / 4] ^= std::byte{1};
    write_file(file, bytes);
    run.cancel_after(1000);
    CHECK((bytes_in(studio.paint(run, options)) == expected));
    CHECK(std::any_of(run.messages.begin(), run.messages.end(),
                      [](const std::string& m) { return m.find("warning: the checkpoint cannot be used") == 0; }));
}

TEST_CASE("where a loss is not finite the run goes back and halves the rate, and ends with the same bytes when interrupted then")
{
    Studio studio;
    const Value fragile = Value::Map{{"glass", Value::Map{{"type", "fragile"}}}};
    // Each of four layers moves by the rate, from 0.45 on: past 0.9 after three steps of 0.04, not after two of them and one of
    // 0.02.
    const auto options = [&](double rate)
    {
        return Studio::options(
            fragile, {{"rate", rate}, {"max_steps", 4}, {"decay_start", 1.0}, {"init", "color"}, {"checkpoint_steps", 2}});
    };
    testing::TestRun run;
    const auto expected = bytes_in(studio.paint(run, options(0.04)));
    CHECK(run.reported.at("rollbacks").as_int() == 1);
    // Steps 1 to 3, then steps 3 and 4 again from the checkpoint after step 2.
    CHECK(run.metrics.at("loss").size() == 5);
    testing::TestRun never;
    const auto slow = bytes_in(studio.paint(never, options(0.02)));
    CHECK(never.reported.find("rollbacks") == nullptr);
    CHECK((slow != expected));

    int interruptions = 0;
    for (int calls = 1; calls < 12; ++calls)
    {
        CAPTURE(calls);
        const Resumed resumed = canceled_and_resumed(studio, options(0.04), calls);
        CHECK((resumed.bytes == expected));
        interruptions += resumed.canceled;
    }
    CHECK(interruptions >= 6);

    testing::TestRun hopeless;
    CHECK_THROWS_WITH(studio.paint(hopeless, options(10)),
                      Catch::Contains("glass") && Catch::Contains("3 times") && Catch::Contains("checkpoint"));
}

TEST_CASE("a state that is bad when its checkpoint is due is thrown away, and the good one before it kept")
{
    Studio studio;
    const Value fragile = Value::Map{{"glass", Value::Map{{"type", "fragile"}}}};
    // 0.45 at first, four layers: past 0.9 after four steps of 0.03, which is when a checkpoint is due. From the one after step 2
    // on at half the rate it is not; two checkpoints later it is again, so that the run goes back twice.
    const auto options = Studio::options(
        fragile, {{"rate", 0.03}, {"max_steps", 7}, {"decay_start", 1.0}, {"init", "color"}, {"checkpoint_steps", 2}});
    testing::TestRun run;
    const auto expected = bytes_in(studio.paint(run, options));
    CHECK(run.reported.at("rollbacks").as_int() >= 2);
    for (int calls = 1; calls < 20; ++calls)
    {
        CAPTURE(calls);
        const Resumed resumed = canceled_and_resumed(studio, options, calls);
        CHECK((resumed.bytes == expected));
    }
}
