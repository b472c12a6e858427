#include "program.h"

#include "store/stage_log.h"

#include <algorithm>

namespace
{

const char* const printing_room = R"(version: 1
stages:
  talker: {type: test.misbehave, how: print_lines}
  silent: {type: test.source}
)";

std::vector<fs::path> log_files(const Workplace& place)
{
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/logs")))
        files.push_back(entry.path());
    return files;
}

std::vector<std::string> lines_of(const std::string& text)
{
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
    return lines;
}

}  // namespace

TEST_CASE("What a stage prints is kept, to a megabyte, with a line that says what was left out", "[log]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", printing_room);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const Finished shown = place.run({"log", "room.yaml", "talker"});
    REQUIRE(shown.code == 0);
    CHECK(shown.out.size() > (std::size_t{1} << 19U));
    CHECK(shown.out.size() <= (std::size_t{1} << 20U));
    const auto lines = lines_of(shown.out);
    CHECK(lines.at(0) == "all of it");
    CHECK(lines.at(1) == "line 0");
    CHECK(std::ranges::count(lines, "to the other stream") == 1);
    CHECK(std::ranges::count(lines, "line 99999") == 1);
    CHECK(std::ranges::count(lines, "still here") == 1);
    const auto note = std::ranges::find_if(lines, [](const std::string& line) { return line.starts_with("--- "); });
    REQUIRE(note != lines.end());
    std::size_t left_out = 0;
    REQUIRE(std::sscanf(note->c_str(), "--- %zu lines left out here", &left_out) == 1);
    // Two lines, those that are counted, and a message, in place of which is the note.
    CHECK(lines.size() - 1 + left_out == 100'003);
    const Finished silent = place.run({"log", "room.yaml", "silent"});
    CHECK(silent.code == 0);
    CHECK(silent.out == "made 1.000000\n");
}

TEST_CASE("A log belongs to a result: who finds the result finds the log, and it is removed with it", "[log]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", printing_room);
    REQUIRE(place.run({"run", "room.yaml", "--set", "talker.how=nothing"}).code == 0);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(log_files(place).size() == 3);
    REQUIRE(place.run({"run", "room.yaml", "--set", "talker.how=nothing"}).code == 0);
    CHECK(place.run({"log", "room.yaml", "talker"}).out == "still here\n");
    fs::copy_file(place.file("room.yaml"), place.file("same.yaml"));
    REQUIRE(place.run({"run", "same.yaml"}).code == 0);
    CHECK(contains(place.run({"log", "same.yaml", "talker"}).out, "line 99999"));
    const Finished report = place.run({"run", "same.yaml", "--json-log"});
    const auto run = fresco::parse_json(place.read("out/run.json"), "run.json");
    CHECK(contains(fresco::read_text_file(run.at("stages").as_list().at(0).at("log").as_string()), "line 99999"));

    fs::remove(place.file("same.yaml"));
    REQUIRE(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
    CHECK(log_files(place).size() == 2);
    CHECK(place.run({"log", "room.yaml", "talker"}).out == "still here\n");
}

TEST_CASE("The log of a stage that failed is kept, and the error names the command that shows it", "[log]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", printing_room);
    const Finished failed = place.run({"run", "room.yaml", "--set", "talker.how=print_and_throw"});
    CHECK(failed.code == 1);
    CHECK(contains(failed.err, "(test.misbehave): enough\n    all that it printed: fresco log room.yaml talker\n"));
    const auto lines = lines_of(place.run({"log", "room.yaml", "talker"}).out);
    CHECK(lines == std::vector<std::string>{"all of it", "line 0", "line 1", "line 2", "to the other stream", "error: enough"});
    const Finished elsewhere = place.run({"run", "room.yaml", "--set", "talker.how=print_and_throw", "--store", "a store"});
    CHECK(contains(elsewhere.err, "fresco log room.yaml talker --store 'a store'\n"));
    // Said in the error already.
    CHECK_FALSE(contains(place.run({"run", "room.yaml", "--set", "talker.how=segfault"}).err, "fresco log"));
    CHECK(contains(place.run({"log", "room.yaml", "talker"}).out, "error: its process ended: Segmentation fault (signal 11)\n"));
    CHECK(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
    const Finished gone = place.run({"log", "room.yaml", "talker"});
    CHECK(gone.code == 3);
    CHECK(contains(gone.err, "the log of the stage 'talker' was removed with its result"));
}

TEST_CASE("fresco log says what there is where it finds none", "[log]")
{
    Workplace place({"good"});
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source}\n");
    CHECK(contains(place.run({"log", "room.yaml", "source"}).err, "not a store; set its folder with --store"));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const Finished wrong = place.run({"log", "room.yaml", "sorce"});
    CHECK(wrong.code == 3);
    CHECK(contains(wrong.err, "error: room.yaml: no stage 'sorce' has run (did you mean 'source'?)"));
    place.write("other.yaml", "version: 1\nstages: {}\n");
    CHECK(contains(place.run({"log", "other.yaml", "source"}).err, "other.yaml: none of its stages has run with the store "));
    CHECK(contains(place.run({"log", "nothing.yaml", "source"}).err, "nothing.yaml: no such file"));
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
