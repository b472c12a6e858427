#include "program.h"

#include "base/machine.h"
#include "base/process.h"
#include "run/stage_limits.h"
#include <fresco/error.h>

#include <fcntl.h>

// More of what plugins do to their process, to others and to the machine: prove_hostile_plugins.

using namespace fresco::host;

namespace
{

/// A stage that misbehaves beside one that does not, and one that needs the first.
const char* const pipeline = R"(version: 1
vars: {how: nothing}
stages:
  bad:    {type: test.misbehave, how: "${how}"}
  after:  {type: test.add, input: {left: bad}, log: log}
  good:   {type: test.slow, steps: 3, step_ms: 20, log: log}
  text:   {type: test.sink, input: good, path: good.txt, log: log}
)";

}  // namespace

TEST_CASE("What a stage does to its process ends that stage, by name, and nothing else", "[isolation]")
{
    struct Way
    {
        const char* how;
        const char* told;  ///< Nothing: it does no harm.
        const char* time = "10m";
        const char* memory = "8G";
    };
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", pipeline);
    for (const Way& way : {Way{"segfault", "crashed: Segmentation fault (signal 11)"},
                           {"overflow", "its stack overflowed"},
                           {"exit_canceled", "ended with exit code 75 before the stage was done"},
                           {"loop", "it exceeded the time limit of 0.3 s", "0.3s"},
                           {"allocate_elsewhere", "the limit is 300 MB: raise --isolate-memory", "10m", "300M"},
                           {"throw_int", "something other than an exception was thrown"},
                           {"garbage", ""}})
    {
        INFO(way.how);
        fs::remove_all(place.file("out"));
        const Finished finished = place.run({"run", "room.yaml", "--json-log", "--set", std::string("how=") + way.how,
                                             "--isolate", "bad", "--isolate-time", way.time, "--isolate-memory", way.memory});
        auto state = outcomes(finished);
        const bool fails = *way.told != '\0';
        CHECK(finished.code == (fails ? 1 : 0));
        CHECK(state["bad"] == (fails ? "failed" : "ran"));
        CHECK(state["after"] == (fails ? "not run" : "ran"));
        CHECK(place.read("out/good.txt") == "3.000000\n");
        const std::string error = outcomes(finished, "error")["bad"];
        CHECK(contains(error, way.told));
        if (fails)
            CHECK(contains(error, "room.yaml:4:3: error: stage bad (test.misbehave): "));
        CHECK(fs::is_empty(place.file(".fresco/tmp")));
    }
    CHECK(place.run({"store", "verify"}).code == 0);
}

TEST_CASE("A stage that prints without end does not keep the host from holding it to its time", "[isolation]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", pipeline);
    const Finished finished = place.run({"run", "room.yaml", "--set", "how=print", "--isolate", "bad", "--isolate-time", "0.3s"});
    CHECK(finished.code == 1);
    CHECK(contains(finished.err, "raise --isolate-time, or find out where it hangs"));
    CHECK(place.read("out/good.txt") == "3.000000\n");
}

TEST_CASE("Limits that are not reached change nothing", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 8, step_ms: 60}\n");
    const Finished plain = place.make({"--json-log", "--store", "plain"});
    const Finished held = place.make({"--json-log", "--store", "held", "--isolate", "all", "--isolate-memory", "slow=1G",
                                      "--isolate-memory", "2G", "--isolate-time", "10m"});
    const std::string object = outcomes(plain, "object")["slow"];
    CHECK(outcomes(held, "object")["slow"] == object);
    CHECK(place.read("plain/objects/" + object + "/counted/table.json") ==
          place.read("held/objects/" + object + "/counted/table.json"));
    CHECK(contains(held.out, "\"progress\""));
    CHECK(contains(held.out, "\"loss\""));
}

TEST_CASE("A stage with checkpoints goes on from where its time ended", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 60, step_ms: 40, log: log}\n");
    CHECK(place.run({"run", "room.yaml", "--isolate", "slow", "--isolate-time", "1s"}).code == 1);
    CHECK(place.log() == Words{"slow from 0", "slow was stopped"});
    place.make();
    CHECK(place.log().size() == 3);
    CHECK(place.log().back() != "slow from 0");
}

TEST_CASE("Wrong limits are refused before anything runs", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, log: log}\n");
    for (const auto& [arguments, text] : std::vector<std::pair<Words, std::string>>{
             {{"--isolate", "slwo"}, "--isolate slwo: unknown stage 'slwo' (did you mean 'slow'?)"},
             {{"--isolate-time", "10m"}, "--isolate"},
             {{"--isolate", "slow", "--isolate-time", "soon"}, "--isolate-time soon: expected a time such as"},
             {{"--isolate", "slow", "--isolate-memory", "4"}, "--isolate-memory 4: expected an amount of memory such as"},
             {{"--isolate", "slow", "--isolate-memory", "fast=4G"}, "the stage 'fast' is not isolated: add --isolate fast"}})
    {
        Words all{"run", "room.yaml"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Finished finished = place.run(all);
        CHECK(finished.code == 2);
        CHECK(contains(finished.out + finished.err, text));
    }
    CHECK(place.log().empty());
}

TEST_CASE("Amounts of memory and times are read as people write them", "[isolation]")
{
    for (const auto& [text, mb] : {std::pair("4G", 4096.0), {"1.5 GB", 1536}, {"512MiB", 512}, {"1048576k", 1024}})
        CHECK(parse_memory_mb(text) == mb);
    for (const auto& [text, seconds] : {std::pair("90", 90.0), {"1h30m", 5400}, {"2 m 5s", 125}})
        CHECK(parse_seconds(text) == seconds);
    for (const char* text : {"", "G", "4X", "4G4", "-4G", "nan", "1e3G", "0G", "inf"})
        CHECK_THROWS_AS(parse_memory_mb(text), fresco::Error);
    for (const char* text : {"", "m", "5d", "3s2m", "-1s", "0", "1m 2m", "inf"})
        CHECK_THROWS_AS(parse_seconds(text), fresco::Error);
}

TEST_CASE("Without words an isolated stage gets most of the machine and ten times what is expected", "[isolation]")
{
    Pipeline made;
    for (const char* name : {"quick", "long", "free"})
    {
        made.stages.emplace_back();
        made.stages.back().name = made.stages.back().own_name = name;
    }
    const auto limits = stage_limits({{"quick", "long"}, {}, {"quick=5m"}}, made, {{"quick", 2}, {"long", 100}});
    // A stage's own goes before that of all.
    const auto both = stage_limits({{"quick", "long"}, {}, {"quick=5m", "1m"}}, made, {});
    CHECK(both.at("quick").seconds == 300);
    CHECK(both.at("long").seconds == 60);
    CHECK(limits.size() == 2);
    CHECK(limits.at("quick").seconds == 300);
    CHECK(limits.at("long").seconds == 1000);
    CHECK(limits.at("long").memory_mb == Approx(0.9 * machine_memory_mb()));
    CHECK(stage_limits({{"all"}, {}, {}}, made, {}).at("free").seconds == 600);
    // Of a matrix.
    made.stages[0].own_name = made.stages[1].own_name = "painted";
    CHECK(stage_limits({{"painted"}, {"quick=2G"}, {"painted=1m"}}, made, {}).at("quick").memory_mb == 2048);
    CHECK(stage_limits({{"painted"}, {}, {"painted=1m"}}, made, {}).at("long").seconds == 60);
}

TEST_CASE("Lines without end and writers without end are taken in pieces", "[isolation]")
{
    int pipes[2];
    REQUIRE(pipe(pipes) == 0);
    const fresco::FileDescriptor reading(pipes[0]);
    fresco::FileDescriptor writing(pipes[1]);
    fcntl(reading.get(), F_SETFL, O_NONBLOCK);
    const std::string text = "ab\n" + std::string(10, 'x') + "yz\nlast";
    REQUIRE(write(writing.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size()));
    fresco::LineBuffer lines(6);
    CHECK(lines.read_from(reading.get()));
    Words got;
    for (std::string line; lines.next(line);)
        got.push_back(line);
    CHECK(got == Words{"ab", "xxxxxx", "xxxxyz"});
    CHECK(lines.rest() == "last");
    writing.reset();
    CHECK_FALSE(lines.read_from(reading.get()));
}
