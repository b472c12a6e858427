#include "program.h"

#include "store/stage_log.h"

namespace
{

const char* const printing_room = R"(
  talker: {type: test.misbehave, how: print_lines}
  silent: {type: test.source}
)";

std::size_t log_count(const Workplace& place)
{
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(place.file(".fresco/logs")), {}));
}

}  // namespace

TEST_CASE("What a stage prints is kept, to a megabyte, with a line that says what was left out", "[log]")
{
    RoomPlace place(printing_room, {"good", "misbehaving"});
    place.make();
    const Finished shown = place.run({"log", "room.yaml", "talker"}, 0);
    CHECK(shown.out.size() > (std::size_t{1} << 19U));
    CHECK(shown.out.size() <= (std::size_t{1} << 20U));
    const Words lines = lines_of(shown.out);
    CHECK(lines.at(0) == "all of it");
    CHECK(lines.at(1) == "line 0");
    for (const char* line : {"to the other stream", "line 299999", "still here"})
        CHECK(std::ranges::count(lines, line) == 1);
    const auto note = std::ranges::find_if(lines, [](const std::string& line) { return line.starts_with("--- "); });
    REQUIRE(note != lines.end());
    std::size_t left_out = 0;
    REQUIRE(std::sscanf(note->c_str(), "--- %zu lines left out here", &left_out) == 1);
    // Two lines, those that are counted, and a message, in place of which is the note.
    CHECK(lines.size() - 1 + left_out == 300'003);
    CHECK(place.run({"log", "room.yaml", "silent"}).out == "made 1.000000\n");
}

TEST_CASE("A log belongs to a result: who finds the result finds the log, and it is removed with it", "[log]")
{
    RoomPlace place(printing_room, {"good", "misbehaving"});
    const Words quiet{"--set", "talker.how=nothing"};
    place.make(quiet);
    place.make();
    CHECK(log_count(place) == 3);
    place.make(quiet);
    CHECK(place.run({"log", "room.yaml", "talker"}).out == "still here\n");
    fs::copy_file(place.file("room.yaml"), place.file("same.yaml"));
    REQUIRE(place.run({"run", "same.yaml"}).code == 0);
    CHECK(contains(place.run({"log", "same.yaml", "talker"}).out, "line 299999"));
    const fresco::Value stage = place.read_json("out/run.json").at("stages").as_list().at(0);
    CHECK(contains(fresco::read_text_file(stage.at("log").as_string()), "line 299999"));
    fs::remove(place.file("same.yaml"));
    for (const Words& keeping : {Words{"store", "gc"}, {"store", "gc", "--dry-run", "--keep-days", "0"}})
        place.run(keeping, 0);
    CHECK(log_count(place) == 3);
    place.run({"store", "gc", "--keep-days", "0"}, 0);
    CHECK(log_count(place) == 2);
    CHECK(place.run({"log", "room.yaml", "talker"}).out == "still here\n");
}

TEST_CASE("The log of a stage that failed is kept, and the error names the command that shows it", "[log]")
{
    RoomPlace place(printing_room, {"good", "misbehaving"});
    const auto failed = [&](const std::string& how, const std::string& store) {
        return place.run({"run", "room.yaml", "--set", "talker.how=" + how, "--store", store}, 1).err;
    };
    const auto log = [&] { return place.run({"log", "room.yaml", "talker"}); };
    CHECK(contains(failed("print_and_throw", ".fresco"), "enough\n    all that it printed: fresco log room.yaml talker\n"));
    CHECK(lines_of(log().out) == Words{"all of it", "line 0", "line 1", "line 2", "to the other stream", "error: enough"});
    CHECK(contains(failed("print_and_throw", "a store"), "fresco log room.yaml talker --store 'a store'\n"));
    // Said in the error already.
    CHECK_FALSE(contains(failed("segfault", ".fresco"), "fresco log"));
    CHECK(contains(log().out, "error: its process ended: Segmentation fault (signal 11)\n"));
    CHECK(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
    CHECK(log().code == 3);
    CHECK(contains(log().err, "the log of the stage 'talker' was removed with its result"));
}

TEST_CASE("fresco log says what there is where it finds none", "[log]")
{
    RoomPlace place("\n  source: {type: test.source}\n");
    place.write("other.yaml", "version: 1\nstages: {}\n");
    const auto problem = [&](const std::string& pipeline) { return place.run({"log", pipeline, "sorce"}, 3).err; };
    CHECK(contains(problem("room.yaml"), "not a store; set its folder with --store"));
    place.make();
    CHECK(contains(problem("room.yaml"), "error: room.yaml: no stage 'sorce' has run (did you mean 'source'?)"));
    CHECK(contains(problem("other.yaml"), "other.yaml: none of its stages has run with the store "));
    CHECK(contains(problem("nothing.yaml"), "nothing.yaml: no such file"));
}

TEST_CASE("The log of a stage that resumes goes on", "[log]")
{
    const fresco::testing::TemporaryFolder folder;
    const fs::path file = folder.path() / "key.log";
    for (const bool resumes : {false, true})
    {
        fresco::host::StageLog log(file);
        log.add("before it begins");
        CHECK(fs::exists(file) == resumes);
        log.begin(resumes);
        log.add("one");
        log.flush();
    }
    CHECK(fresco::read_text_file(file) == "before it begins\none\n--- resumed ---\nbefore it begins\none\n");
    fresco::host::StageLog(file).begin(false);
    CHECK(fresco::read_text_file(file).empty());
    // Nowhere to write: no run ends for it.
    fresco::host::StageLog nowhere(folder.path() / "no" / "key.log");
    nowhere.begin(false);
    nowhere.add("lost");
    CHECK_NOTHROW(nowhere.flush());
}
