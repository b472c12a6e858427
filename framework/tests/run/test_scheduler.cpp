#include "program.h"

namespace
{

const char* const diamond = R"(version: 1
stages:
  source: {type: test.source, value: 5, log: log}
  left:   {type: test.add, input: {left: source}, plus: 1, wait_ms: 300, log: log}
  right:  {type: test.add, input: {left: source}, plus: 2, wait_ms: 300, log: log}
  join:   {type: test.add, input: {left: left, right: right}, plus: 3, log: log}
  text:   {type: test.sink, input: join, path: sum.txt, log: log}
  other:  {type: test.sink, input: left, path: deep/left.txt, log: log}
)";

std::size_t runs_of(const Workplace& place, const std::string& beginning)
{
    std::size_t count = 0;
    for (const auto& line : place.log())
        count += line.starts_with(beginning) ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("Each stage of a diamond runs once, all ends are reached, branches run side by side")
{
    Workplace place;
    place.write("room.yaml", diamond);
    const Finished first = place.run({"run", "room.yaml", "--cores", "2", "--json-log"});
    INFO(first.err);
    REQUIRE(first.code == 0);
    CHECK(place.read("out/sum.txt") == "16.000000\n");
    CHECK(place.read("out/deep/left.txt") == "6.000000\n");
    CHECK(runs_of(place, "source") == 1);
    CHECK(runs_of(place, "sink") == 2);
    const auto log = place.log();
    REQUIRE(log.size() == 9);
    // Both branches began before either ended.
    CHECK(log[1].starts_with("add begins"));
    CHECK(log[2].starts_with("add begins"));
    for (const auto& [stage, state] : states(first))
        CHECK(state == "ran");

    SECTION("A second run does nothing, at once")
    {
        place.clear_log();
        const Finished second = place.run({"run", "room.yaml", "--json-log"});
        CHECK(second.code == 0);
        CHECK(second.seconds < 1);
        CHECK(place.log().empty());
        for (const auto& [stage, state] : states(second))
            CHECK(state == "stored");
    }
    SECTION("One changed option runs only what depends on it")
    {
        place.clear_log();
        const Finished changed = place.run({"run", "room.yaml", "--set", "right.plus=10", "--json-log"});
        CHECK(changed.code == 0);
        auto state = states(changed);
        CHECK(state["source"] == "stored");
        CHECK(state["left"] == "stored");
        CHECK(state["right"] == "ran");
        CHECK(state["join"] == "ran");
        CHECK(state["text"] == "ran");
        CHECK(state["other"] == "stored");
        CHECK(place.read("out/sum.txt") == "24.000000\n");
        CHECK(place.log().size() == 5);
    }
    SECTION("An option that cannot change the result runs nothing")
    {
        CHECK(place.run({"run", "room.yaml", "--set", "right.wait_ms=1"}).code == 0);
        CHECK(place.log().size() == 9);
    }
    SECTION("A removed or edited file below --out is put back")
    {
        fs::remove(place.file("out/sum.txt"));
        place.write("out/deep/left.txt", "scribble\n");
        place.clear_log();
        CHECK(place.run({"run", "room.yaml"}).code == 0);
        CHECK(place.read("out/sum.txt") == "16.000000\n");
        CHECK(place.read("out/deep/left.txt") == "6.000000\n");
        CHECK(place.log().empty());
    }
    SECTION("What is not read need not be there")
    {
        for (const auto& entry : fs::directory_iterator(place.file(".fresco/objects")))
            if (fs::exists(entry.path() / "sum"))
                fs::remove_all(entry.path());
        place.clear_log();
        const Finished again = place.run({"run", "room.yaml", "--json-log"});
        CHECK(again.code == 0);
        CHECK(place.log().empty());
        CHECK(states(again)["join"] == "not needed");
    }
}

TEST_CASE("Rules for parts that a stage turns out not to make are refused before anything else runs")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
vars: {name: flor}
stages:
  dark:  {type: test.paint, log: log}
  rules: {type: test.rules, input: {parts: parts, dark: dark}, rules: {"*": dark, floor: dark}, log: log}
  sum:   {type: test.sink, input: rules, path: rules.txt, log: log}
  first: {type: test.source, log: log}
  parts: {type: test.parts, name: "${name}", log: log}
  other: {type: test.sink, input: first, path: other.txt, log: log}
)");
    const std::string wrong =
        "room.yaml:5:3: error: stage rules (test.rules): option 'rules': stage parts made no 'floor' (did you "
        "mean 'flor'?)";
    const Finished first = place.run({"run", "room.yaml", "--cores", "1", "--json-log"});
    INFO(first.err);
    CHECK(first.code == 1);
    CHECK(place.log() == std::vector<std::string>{"parts", "source", "sink other.txt"});
    auto state = states(first);
    CHECK(state["dark"] == "not needed");
    CHECK(state["rules"] == "failed");
    CHECK(state["sum"] == "not run");

    place.clear_log();
    CHECK_THAT(place.run({"plan", "room.yaml"}).out, Catch::Contains("made no 'floor'"));
    const Finished second = place.run({"run", "room.yaml"});
    CHECK(second.code == 1);
    CHECK_THAT(second.err, Catch::Contains(wrong));
    CHECK(place.log().empty());

    CHECK(place.run({"run", "room.yaml", "--set", "name=floor", "--cores", "1"}).code == 0);
    CHECK(place.log() == std::vector<std::string>{"parts", "paint", "rules", "sink rules.txt"});
}

TEST_CASE("Equal files with other files beside them are other inputs")
{
    Workplace place;
    for (const char* folder : {"one", "other"})
    {
        place.write(std::string(folder) + "/list", "123");
        place.write(std::string(folder) + "/near", folder[1] == 'n' ? "1" : "2");
    }
    place.write("room.yaml", R"(version: 1
vars: {folder: one}
stages:
  near: {type: test.source, value: 0, file: "${folder}/list", beside: near, log: log}
  text: {type: test.sink, input: near, path: x.txt}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "4.000000\n");
    REQUIRE(place.run({"run", "room.yaml", "--set", "folder=other"}).code == 0);
    CHECK(place.read("out/x.txt") == "5.000000\n");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "4.000000\n");
    CHECK(place.log().size() == 2);
}

TEST_CASE("With one core, stages run one after the other")
{
    Workplace place;
    place.write("room.yaml", diamond);
    REQUIRE(place.run({"run", "room.yaml", "--cores", "1"}).code == 0);
    const auto log = place.log();
    for (std::size_t i = 0; i + 1 < log.size(); ++i)
        if (log[i].starts_with("add begins"))
            CHECK(log[i + 1].starts_with("add ends"));
}

TEST_CASE("Stages side by side are expected to need no more memory together than there is")
{
    Workplace place;
    // Each says that it takes 30 MB.
    place.write("room.yaml", "version: 1\nstages:\n  one: {type: test.source, value: 1}\n  two: {type: test.source, value: 2}\n");
    const auto threads = [&](const std::string& memory)
    {
        const Finished finished =
            place.run({"run", "room.yaml", "--cores", "2", "--memory", memory, "--store", memory, "--json-log"});
        REQUIRE(finished.code == 0);
        std::vector<std::int64_t> counts;
        for (const auto& event : events(finished.out))
            if (event.at("event").as_string() == "begin")
                counts.push_back(event.at("threads").as_int());
        return counts;
    };
    CHECK(threads("100") == std::vector<std::int64_t>{1, 1});
    CHECK(threads("40") == std::vector<std::int64_t>{2, 2});
}

TEST_CASE("A wire from another output of the same stage is another input")
{
    Workplace place;
    const std::string stages =
        "version: 1\nstages:\n  maybe: {type: test.maybe}\n  text: {type: test.sink, path: x.txt, input: maybe.";
    for (const auto& [output, sum] : {std::pair{"table", "7.000000\n"}, {"always", "1.000000\n"}})
    {
        place.write("room.yaml", stages + output + "}\n");
        REQUIRE(place.run({"run", "room.yaml"}).code == 0);
        CHECK(place.read("out/x.txt") == sum);
    }
}

TEST_CASE("--until runs a stage and what it needs")
{
    Workplace place;
    place.write("room.yaml", diamond);
    const Finished part = place.run({"run", "room.yaml", "--until", "left", "--json-log"});
    CHECK(part.code == 0);
    CHECK(states(part).size() == 2);
    CHECK(place.log().size() == 3);
    CHECK(!fs::exists(place.file("out/sum.txt")));
    const Finished wrong = place.run({"run", "room.yaml", "--until", "lefft"});
    CHECK(wrong.code != 0);
    CHECK(contains(wrong.err, "lefft"));
}

TEST_CASE("A failing stage stops only what depends on it and is named with place, inputs and reason")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source, log: log}
  bad:    {type: test.fail, input: source, how: error}
  behind: {type: test.sink, input: bad, path: bad.txt, log: log}
  slow:   {type: test.slow, input: source, steps: 10, log: log}
  good:   {type: test.sink, input: slow, path: good.txt, log: log}
)");
    const Finished finished = place.run({"run", "room.yaml", "--json-log"});
    CHECK(finished.code == 1);
    auto state = states(finished);
    CHECK(state["bad"] == "failed");
    CHECK(state["behind"] == "not run");
    CHECK(state["good"] == "ran");
    CHECK(fs::exists(place.file("out/good.txt")));
    CHECK(!fs::exists(place.file("out/bad.txt")));

    const Finished text = place.run({"run", "room.yaml"});
    CHECK(text.code == 1);
    CHECK(contains(text.err, "room.yaml:4:3: error: stage bad (test.fail): mesh.ply:7: three vertices expected"));
    CHECK(contains(text.err, "input = source.table"));
}

TEST_CASE("Two ends that would write the same file are refused before anything runs")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source, log: log}
  one:    {type: test.sink, input: source, path: a/x.txt}
  two:    {type: test.sink, input: source, path: a/x.txt}
)");
    const Finished finished = place.run({"run", "room.yaml"});
    CHECK(finished.code == 2);
    CHECK(contains(finished.err, "room.yaml:5:50: error: "));
    CHECK(contains(finished.err, "a/x.txt"));
    CHECK(place.log().empty());
}

TEST_CASE("Interrupted in order, a run goes on from its checkpoint")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  slow: {type: test.slow, steps: 60, step_ms: 50, log: log}
  text: {type: test.sink, input: slow, path: count.txt, log: log}
)");
    for (const int number : {SIGINT, SIGTERM})
    {
        const auto run = place.start({"run", "room.yaml"});
        const std::size_t lines = place.log().size();
        Workplace::wait_until([&] { return place.log().size() > lines; });
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        run->signal(number);
        if (number == SIGTERM)  // Sent again it is no demand to hurry.
        {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            run->signal(number);
        }
        const Finished stopped = run->wait();
        CHECK(stopped.code == 75);
        CHECK(stopped.seconds < 8);
        CHECK(!fs::exists(place.file("out/count.txt")));
    }
    // Of the six seconds that it says it takes, those of the steps that are done are not planned, nor taken for measured.
    const auto plan = fresco::parse_json(place.run({"plan", "room.yaml", "--json"}).out);
    const auto& slow = plan.at("stages").as_list().at(0);
    const double seconds = slow.at("cost").at("seconds").as_double();
    CHECK(seconds > 1);
    CHECK(seconds < 5.8);
    CHECK(slow.at("reason").as_string() == "interrupted at " + std::to_string(std::lround(100 * (1 - seconds / 6))) + " %");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const std::string stats = place.read(".fresco/stats.jsonl");
    const auto costs = fresco::parse_json(stats.substr(0, stats.find('\n')));
    CHECK(costs.at("type").as_string() == "test.slow");
    CHECK(costs.at("estimated").as_list().at(0).as_double() == Approx(seconds));
    CHECK(place.read("out/count.txt") == "60.000000\n");
    const auto log = place.log();
    REQUIRE(log.size() == 6);
    CHECK(log[0] == "slow from 0");
    CHECK(log[1] == "slow was stopped");
    CHECK(std::stoi(log[2].substr(10)) >= 3);
    CHECK(std::stoi(log[4].substr(10)) > std::stoi(log[2].substr(10)));
    CHECK(fs::is_empty(place.file(".fresco/checkpoints")));
}

TEST_CASE("Copying thousands of files to --out is interrupted too, and the next run goes on with it")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source}
  text:   {type: test.sink, input: source, copies: 400}
)");
    const auto copied = [&]
    {
        const fs::path folder = place.file("out/copies");
        return fs::exists(folder) ? std::distance(fs::directory_iterator(folder), fs::directory_iterator()) : 0;
    };
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return fs::exists(place.file("out/copies/9.txt")); });
    run->signal(SIGINT);
    CHECK(run->wait().code == 75);
    CHECK(copied() < 400);
    CHECK(contains(place.read("out/run.json"), "\"outcome\": \"interrupted\""));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(copied() == 400);
}

TEST_CASE("A stage that does not listen is ended all the same")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  bad: {type: test.fail, how: stubborn, log: log}\n");
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    run->signal(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    run->signal(SIGINT);
    const Finished stopped = run->wait();
    CHECK(stopped.code == 75);
    CHECK(stopped.seconds < 6);
}

TEST_CASE("Two runs at once make a result once")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  slow: {type: test.slow, steps: 20, step_ms: 50, log: log}
  text: {type: test.sink, input: slow, path: count.txt, log: log}
)");
    const auto first = place.start({"run", "room.yaml", "--out", "out1"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    const auto second = place.start({"run", "room.yaml", "--out", "out2"});
    const Finished one = first->wait();
    const Finished two = second->wait();
    CHECK(one.code == 0);
    CHECK(two.code == 0);
    CHECK(contains(two.err, "waiting for another run"));
    CHECK(runs_of(place, "slow") == 1);
    CHECK(place.read("out1/count.txt") == place.read("out2/count.txt"));
    CHECK(place.read("out2/count.txt") == "20.000000\n");
}

TEST_CASE("One stage's process that is told to stop ends the run in order: the others stop at their next check")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  one: {type: test.slow, steps: 1000, step_ms: 20, log: log}
  two: {type: test.slow, steps: 1001, step_ms: 20, log: log}
)");
    const auto run = place.start({"run", "room.yaml", "--cores", "2", "--json-log"});
    Workplace::wait_until([&] { return place.log().size() == 2; });
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    REQUIRE(kill(run->a_child(), SIGTERM) == 0);
    const Finished stopped = run->wait();
    CHECK(stopped.code == 75);
    CHECK(stopped.seconds < 8);
    for (const auto& [stage, state] : states(stopped))
        CHECK(state == "interrupted");
    // Each said itself that it stopped; a killed one says nothing.
    const auto log = place.log();
    CHECK(std::count(log.begin(), log.end(), "slow was stopped") == 2);
}

TEST_CASE("Statistics that cannot be saved are reported and do not end the run")
{
    Workplace place;
    place.write("room.yaml", diamond);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    // In the way of writing: a folder in place of a file, and a file in place of a folder.
    fs::remove(place.file(".fresco/stats.jsonl"));
    fs::create_directory(place.file(".fresco/stats.jsonl"));
    const fs::path records = fs::directory_iterator(place.file(".fresco/stages"))->path();
    fs::remove_all(records);
    std::ofstream(records) << "no folder";
    place.clear_log();
    const Finished finished = place.run({"run", "room.yaml", "--set", "right.plus=10", "--json-log"});
    INFO(finished.err);
    REQUIRE(finished.code == 0);
    auto state = states(finished);
    CHECK(state["right"] == "ran");
    CHECK(state["join"] == "ran");
    CHECK(place.read("out/sum.txt") == "24.000000\n");
    std::string notes;
    for (const auto& event : events(finished.out))
        if (event.at("event").as_string() == "note")
            notes += event.at("text").as_string() + "\n";
    CHECK(contains(notes, "stats.jsonl"));
    CHECK(contains(notes, records.filename().string()));
    place.clear_log();
    CHECK(place.run({"run", "room.yaml", "--set", "right.plus=10"}).code == 0);
    CHECK(place.log().empty());
}

TEST_CASE("A pipeline with many files has nothing to do the next time")
{
    Workplace place;
    for (int i = 0; i < 3000; ++i)
        place.write("scan/" + std::to_string(i), "x");
    place.write("room.yaml", R"(version: 1
stages:
  scan: {type: test.source, folder: scan, log: log}
  text: {type: test.sink, input: scan, path: sum.txt, copies: 1500, log: log}
)");
    // Files of the last two seconds are compared by contents.
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    REQUIRE(place.read("out/sum.txt") == "3001.000000\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.log().size() == 2);
}
