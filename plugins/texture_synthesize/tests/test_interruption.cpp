#include "checkpoint.h"
#include "studio.h"

#include <fresco/error.h>

using namespace studio;

namespace
{

/// Checkpoints after every round; as little work as there can be.
Value small_options(double checkpoint_seconds = 1e-9)
{
    return Studio::options({{"stroke_cm", 30.0}, {"patch_px", 5}, {"size_px", 64}, {"checkpoint_seconds", checkpoint_seconds}});
}

Studio small_wall()
{
    Studio wall;
    wall.picture = brush_picture(60, 50, 3);
    return wall;
}

bool has_line(const testing::TestRun& run, std::string_view text)
{
    return std::ranges::any_of(run.messages, [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE("a run that is canceled anywhere goes on to the same bytes")
{
    const Studio wall = small_wall();
    testing::TestRun whole(1);
    const auto expected = wall.paint(whole, small_options()).bytes;
    REQUIRE(whole.metrics.at("distance").size() == 6);
    int gone_on = 0;
    int checks = 1;
    for (bool canceled = true; canceled; checks += 1 + checks / 6)
    {
        CAPTURE(checks);
        testing::TestRun run(checks % 2 + 1);
        run.cancel_after(checks);
        canceled = false;
        try
        {
            wall.paint(run, small_options());
        }
        catch (const Canceled&)
        {
            canceled = true;
        }
        const std::size_t rounds = run.metrics["distance"].size();
        run.cancel_after(1 << 30);
        if (!canceled)
            break;
        CHECK((wall.paint(run, small_options()).bytes == expected));
        CHECK(run.metrics["distance"].size() == 6);
        CHECK(has_line(run, "going on after round") == (rounds > 0));
        gone_on += rounds > 0;
    }
    CHECK(gone_on >= 5);
    CHECK(checks > 50);
}

TEST_CASE("a run is interrupted twice, also on other numbers of threads")
{
    const Studio wall = small_wall();
    testing::TestRun whole(1);
    const auto expected = wall.paint(whole, small_options()).bytes;
    testing::TestRun run(3);
    run.cancel_after(60);
    CHECK_THROWS_AS(wall.paint(run, small_options()), Canceled);
    const std::size_t first = run.metrics["distance"].size();
    run.cancel_after(40);
    CHECK_THROWS_AS(wall.paint(run, small_options()), Canceled);
    CHECK(run.metrics["distance"].size() > first);
    run.cancel_after(1 << 30);
    CHECK((wall.paint(run, small_options()).bytes == expected));
    CHECK(run.metrics["distance"].size() == 6);
}

TEST_CASE("checkpoints are written as often as asked for")
{
    const Studio wall = small_wall();
    for (const auto& [seconds, is_kept] : {std::pair{0.0, false}, std::pair{1e-9, true}, std::pair{3600.0, false}})
    {
        CAPTURE(seconds);
        testing::TestRun run;
        wall.paint(run, small_options(seconds));
        CHECK(std::filesystem::is_empty(run.checkpoint_folder()) != is_kept);
    }
}

TEST_CASE("a checkpoint that cannot be used is named in a warning, and the run begins again")
{
    const Studio wall = small_wall();
    testing::TestRun whole;
    const auto expected = wall.paint(whole, small_options()).bytes;
    const auto file = whole.checkpoint_folder() / "round.bin";
    const auto good = synthesize::read_checkpoint(file);
    REQUIRE(good);
    const auto bytes = read_file(file);

    testing::TestRun cut;
    write_file(cut.checkpoint_folder() / "round.bin", std::span(bytes).first(bytes.size() / 2));
    CHECK((wall.paint(cut, small_options()).bytes == expected));
    CHECK(has_line(cut, "warning: the checkpoint cannot be used"));
    CHECK(has_line(cut, "round.bin"));

    // Whole, but of other work.
    struct Case
    {
        const char* name;
        std::function<void(synthesize::Checkpoint&)> change;
    };
    const Case cases[] = {{"fewer texels", [](auto& c) { c.colors.pop_back(); }},
                          {"more patches", [](auto& c) { c.matches.emplace_back(); }},
                          {"of a level that there is not", [](auto& c) { c.level = 7; }},
                          {"of a finer level", [](auto& c) { c.level = -1; }},
                          {"of a coarser level's number", [](auto& c) { c.level = 1; }},
                          {"too many rounds", [](auto& c) { c.rounds = 9; }},
                          {"rounds below none", [](auto& c) { c.rounds = -2; }},
                          {"a color that is no number", [](auto& c) { c.colors[3].x = NAN; }},
                          {"a place that is no number", [](auto& c) { c.matches[3].at.y = NAN; }},
                          {"a distance that is no number", [](auto& c) { c.matches[3].distance = NAN; }}};
    for (const Case& c : cases)
    {
        CAPTURE(c.name);
        synthesize::Checkpoint other = *good;
        c.change(other);
        testing::TestRun run;
        synthesize::write_checkpoint(run.checkpoint_folder() / "round.bin", other);
        CHECK((wall.paint(run, small_options()).bytes == expected));
        CHECK(has_line(run, "warning: the checkpoint cannot be used"));
    }
}
