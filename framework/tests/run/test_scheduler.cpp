#include "program.h"

#include <fmt/format.h>

#include <algorithm>

// prove_never_stale shows that no result is stale and no stage runs in vain, and prove_kill tries kills.

namespace
{

const char* const diamond = R"(
  source: {type: test.source, value: 5, log: log}
  left:   {type: test.add, input: {left: source}, plus: 1, log: log}
  right:  {type: test.add, input: {left: source}, plus: 2, log: log}
  join:   {type: test.add, input: {left: left, right: right}, plus: 3, log: log}
  text:   {type: test.sink, input: join, path: sum.txt, log: log}
  other:  {type: test.sink, input: left, path: deep/left.txt, log: log}
)";

/// How the stages of a run on two cores begin, with their threads, and end.
Words course_of(Workplace& place, Words more)
{
    more.insert(more.end(), {"--cores", "2", "--json-log"});
    Words told;
    for (const auto& event : events(place.make(more).out))
        if (const auto& name = event.at("event").as_string(); name == "begin")
            told.push_back(fmt::format("begin {} on {}", event.at("stage").as_string(), event.at("threads").as_int()));
        else if (name == "end")
            told.push_back("end " + event.at("stage").as_string());
    return told;
}

}  // namespace

TEST_CASE("Each stage of a diamond runs once, all ends are reached, branches run side by side")
{
    RoomPlace place(diamond);
    // Each branch waits until both have begun.
    const Finished first = place.make({"--cores", "2", "--json-log", "--set", "left.together=2", "--set", "right.together=2"});
    CHECK(place.read("out/sum.txt") == "16.000000\n");
    CHECK(place.read("out/deep/left.txt") == "6.000000\n");
    const Words log = place.log();
    REQUIRE(log.size() == 9);
    CHECK(log[0] == "source");
    CHECK(log[1].starts_with("add begins"));
    CHECK(log[2].starts_with("add begins"));
    for (const auto& [stage, state] : outcomes(first))
        CHECK(state == "ran");
    place.clear_log();

    SECTION("A removed file below --out is put back, and what is not read need not be there")
    {
        fs::remove(place.file("out/sum.txt"));
        for (const auto& object : place.objects())
            if (fs::exists(object / "sum"))
                fs::remove_all(object);
        // A killed clean-up may leave another run's record of the stage, and results made from a result that is
        // gone.
        place.make({"--set", "right.plus=10", "--until", "join"});
        place.clear_log();
        for (const bool tidied : {false, true})
        {
            CHECK(outcomes(place.make({"--json-log"}))["join"] == "not needed");
            CHECK(place.read("out/sum.txt") == "16.000000\n");
            CHECK(place.log().empty());
            if (!tidied)
                REQUIRE(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
        }
    }
    SECTION("With one core, stages run one after the other; --until runs a stage and what it needs")
    {
        CHECK(outcomes(place.make({"--until", "right", "--cores", "1", "--store", "other", "--json-log"})).size() == 2);
        CHECK(place.log() == Words{"source", "add begins 2.000000", "add ends 2.000000"});
        place.make({"--cores", "1", "--store", "other"});
        CHECK(place.log()[3].starts_with("add begins"));
        CHECK(place.log()[4].starts_with("add ends"));
    }
}

TEST_CASE("Stages side by side are expected to need no more memory together than there is")
{
    // test.source declares 30 MB, and a little less is measured.
    RoomPlace place(R"(
  one: {type: test.source, value: 1}
  two: {type: test.source, value: 2}
)");
    const auto course = [&](const std::string& memory, const std::string& wait_ms)
    {
        return course_of(
            place, {"--memory", memory, "--store", memory, "--set", "one.wait_ms=" + wait_ms, "--set", "two.wait_ms=" + wait_ms});
    };
    const Words one_by_one{"begin one on 2", "end one", "begin two on 2", "end two"};
    CHECK(course("40", "300") == one_by_one);
    CHECK(course("5", "300") == one_by_one);
    const Words together = course("100", "2000");
    CHECK(std::count(together.begin(), together.end(), "begin one on 1") == 1);
    CHECK(std::count(together.begin(), together.end(), "begin two on 1") == 1);
}

TEST_CASE("A stage whose memory is unknown runs alone, and does not wait for those behind it")
{
    RoomPlace place(R"(
  first:   {type: test.source, wait_ms: 100}
  unknown: {type: test.note, text: a}
  last:    {type: test.source, value: 2, wait_ms: 100}
)",
                    {"good", "note"});
    CHECK(course_of(place, {"--memory", "1000"}) ==
          Words{"begin first on 2", "end first", "begin unknown on 2", "end unknown", "begin last on 2", "end last"});
    // Runs with other options have measured it: the first two share the cores, whichever worker speaks first.
    const Words course =
        course_of(place, {"--memory", "1000", "--set", "unknown.text=b", "--set", "first.value=3", "--set", "last.value=4"});
    CHECK(std::count(course.begin(), course.end(), "begin first on 1") == 1);
    CHECK(std::count(course.begin(), course.end(), "begin unknown on 1") == 1);
}

TEST_CASE("A wire from another output of the same stage is another input")
{
    Workplace place;
    for (const auto& [output, sum] : {std::pair<std::string, std::string>{"table", "7.000000\n"}, {"always", "1.000000\n"}})
    {
        place.write_stages("\n  maybe: {type: test.maybe}\n  text: {type: test.sink, path: x.txt, input: maybe." + output +
                           "}\n");
        place.make();
        CHECK(place.read("out/x.txt") == sum);
    }
}

TEST_CASE("A failing stage stops only what depends on it and is named with place, inputs and reason")
{
    RoomPlace place(R"(
  source: {type: test.source, log: log}
  bad:    {type: test.fail, input: source, how: error}
  behind: {type: test.sink, input: bad, path: bad.txt, log: log}
  slow:   {type: test.slow, input: source, steps: 10, log: log}
  good:   {type: test.sink, input: slow, path: good.txt, log: log}
)");
    using States = std::map<std::string, std::string>;
    CHECK(outcomes(place.run({"run", "room.yaml", "--json-log"}, 1)) ==
          States{{"source", "ran"}, {"bad", "failed"}, {"behind", "not run"}, {"slow", "ran"}, {"good", "ran"}});
    CHECK(fs::exists(place.file("out/good.txt")));
    const Finished text = place.run({"run", "room.yaml"}, 1);
    CHECK(contains(text.err, "room.yaml:4:3: error: stage bad (test.fail): mesh.ply:7: three vertices expected"));
    CHECK(contains(text.err, "input = source.table"));
}

TEST_CASE("Interrupted in order, a run goes on from its checkpoint")
{
    RoomPlace place(R"(
  slow: {type: test.slow, steps: 60, step_ms: 1, log: log}
  text: {type: test.sink, input: slow, path: count.txt, log: log}
)");
    // The last is that of a terminal that hangs up.
    for (const int number : {SIGINT, SIGTERM, SIGHUP})
    {
        const std::size_t before = place.log().size();
        // So slow that it is not done before a busy machine hears of the signal.
        const auto run = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=500"});
        wait_until([&] { return place.log().size() > before && run->says("\"progress\""); });
        run->signal(number);
        if (number == SIGTERM)  // Sent again it is no demand to hurry.
        {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            run->signal(number);
        }
        CHECK(run->wait().code == 75);
        CHECK(!fs::exists(place.file("out/count.txt")));
    }
    const auto planned = fresco::parse_json(place.run({"plan", "room.yaml", "--json"}).out).at("stages").as_list().at(0);
    CHECK(planned.at("seconds").is_null());
    const std::string reason = planned.at("reason").as_string();
    REQUIRE(reason.starts_with("interrupted at "));
    const double left = 1 - std::stod(reason.substr(15)) / 100;
    place.make();
    // Work saved in the checkpoint counts.
    const auto took = fresco::parse_json(lines_of(place.read(".fresco/stats.jsonl")).at(1));
    CHECK(took.at("type").as_string() == "test.slow");
    CHECK(took.at("seconds").as_double() >= 0.06 * left / (left + 0.01));
    CHECK(place.read("out/count.txt") == "60.000000\n");
    std::vector<int> begun;
    const Words log = place.log();
    for (const std::string& line : log)
        if (line.starts_with("slow from "))
            begun.push_back(std::stoi(line.substr(10)));
    REQUIRE(begun.size() == 4);
    CHECK(begun.front() == 0);
    CHECK(std::ranges::is_sorted(begun));
    CHECK(begun[1] > 0);
    CHECK(std::ranges::count(log, "slow was stopped") == 3);
    CHECK(fs::is_empty(place.file(".fresco/checkpoints")));
}

TEST_CASE("A stage that stop_at_step ends early goes on from the checkpoint of the whole run, which keeps it")
{
    RoomPlace place(R"(
  slow: {type: test.slow, steps: 60, step_ms: 1, log: log}
  text: {type: test.sink, input: slow, path: count.txt, log: log}
)");
    const auto run = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=500"});
    wait_until([&] { return run->says("\"progress\""); });
    run->signal(SIGINT);
    CHECK(run->wait().code == 75);
    place.make({"--set", "slow.stop_at_step=20"});
    CHECK(place.read("out/count.txt") == "20.000000\n");
    place.make();
    CHECK(place.read("out/count.txt") == "60.000000\n");
    const Words log = place.log();
    const auto kept = std::ranges::find(log, "slow was stopped");
    REQUIRE(kept != log.end());
    const auto is_begin = [](const std::string& line) { return line.starts_with("slow from "); };
    const auto early = std::find_if(kept, log.end(), is_begin);
    REQUIRE(early != log.end());
    CHECK(*early != "slow from 0");
    CHECK(std::count(kept, log.end(), *early) == 2);
}

TEST_CASE("Copying over a thousand files to --out is interrupted too, and the next run goes on with it")
{
    RoomPlace place("\n  source: {type: test.source}\n"
                    "  text: {type: test.sink, input: source, copies: 1500}\n");
    const auto copied = [&] { return std::distance(fs::directory_iterator(place.file("out/copies")), {}); };
#ifndef __SANITIZE_ADDRESS__
    // So slow that the copies are not done before a busy machine hears of the signal.
    place.environment["LD_PRELOAD"] = test_plugin("lacking/lacking.so");
    place.environment["LACKING_SPEED"] = "1";
#endif
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return fs::exists(place.file("out/copies/9.txt")); });
    run->signal(SIGINT);
    CHECK(run->wait().code == 75);
    CHECK(copied() < 1500);
    place.environment.erase("LACKING_SPEED");
    CHECK(contains(place.read("out/run.json"), "\"outcome\": \"interrupted\""));
    place.make();
    CHECK(copied() == 1500);
}

TEST_CASE("A stage that does not listen is ended all the same")
{
    RoomPlace place("\n  bad: {type: test.fail, how: stubborn, log: log}\n");
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return !place.log().empty(); });
    run->signal(SIGINT);
    wait_until([&] { return run->says("again"); });
    run->signal(SIGINT);
    CHECK(run->wait().code == 75);
}

TEST_CASE("One stage's process that is told to stop ends the run in order: the others stop at their next check")
{
    RoomPlace place(R"(
  one: {type: test.slow, steps: 1000, step_ms: 20, log: log}
  two: {type: test.slow, steps: 1001, step_ms: 20, log: log}
)");
    const auto run = place.start({"run", "room.yaml", "--cores", "2", "--json-log"});
    wait_until([&] { return place.log().size() == 2; });
    REQUIRE(kill(run->a_child(), SIGTERM) == 0);
    const Finished stopped = run->wait();
    CHECK(stopped.code == 75);
    for (const auto& [stage, state] : outcomes(stopped))
        CHECK(state == "interrupted");
    // Each said itself that it stopped; a killed one says nothing.
    CHECK(place.logged("slow was stopped") == 2);
}
