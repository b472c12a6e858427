#include "program.h"

#include "base/machine.h"
#include "base/process.h"
#include "run/stage_limits.h"
#include <fresco/error.h>

#include <fcntl.h>
#include <unistd.h>

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

/// An entry of a stage's outcome.
std::string told_of(const Finished& finished, const std::string& stage, const char* entry)
{
    const auto all = events(finished.out);
    REQUIRE(!all.empty());
    for (const auto& outcome : all.back().at("stages").as_list())
        if (outcome.at("stage").as_string() == stage)
            return outcome.at(entry).as_string();
    return "";
}

}  // namespace

TEST_CASE("What a stage does to its process ends that stage, by name, and nothing else", "[isolation]")
{
    struct Way
    {
        const char* how;
        const char* told;
        std::vector<std::string> arguments;
    };
    const std::vector<Way> ways{
        {"segfault", "crashed: Segmentation fault (signal 11)", {}},
        {"overflow", "its stack overflowed", {}},
        {"exit", "ended with exit code 3 before the stage was done", {}},
        {"exit_canceled", "ended with exit code 75 before the stage was done", {}},
        {"loop", ": raise --isolate-time", {"--isolate-time", "bad=0.3s"}},
        {"allocate", "--isolate-memory", {"--isolate-memory", "bad=300M"}},
        {"allocate_elsewhere", "the limit is 300 MB: raise --isolate-memory", {"--isolate-memory", "300M"}},
        {"abort", "crashed: Aborted (signal 6)", {}},
        {"throw_int", "something other than an exception was thrown", {}},
        {"close_channel", "it closed descriptor 3, by which it speaks to the host", {}},
        {"garbage", "", {}}};
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", pipeline);
    for (const Way& way : ways)
    {
        INFO(way.how);
        fs::remove_all(place.file("out"));
        std::vector<std::string> arguments{"run",       "room.yaml", "--json-log", "--set", std::string("how=") + way.how,
                                           "--isolate", "bad"};
        arguments.insert(arguments.end(), way.arguments.begin(), way.arguments.end());
        const Finished finished = place.run(arguments);
        auto state = states(finished);
        const bool fails = *way.told != '\0';
        CHECK(finished.code == (fails ? 1 : 0));
        CHECK(state["bad"] == (fails ? "failed" : "ran"));
        CHECK(state["after"] == (fails ? "not run" : "ran"));
        CHECK((state["good"] == "ran" || state["good"] == "stored"));
        CHECK(place.read("out/good.txt") == "3.000000\n");
        CHECK(contains(told_of(finished, "bad", "error"), way.told));
        if (fails)
            CHECK(contains(told_of(finished, "bad", "error"), "room.yaml:4:3: error: stage bad (test.misbehave): "));
        CHECK(fs::is_empty(place.file(".fresco/tmp")));
    }
    CHECK(place.run({"store", "verify"}).code == 0);
}

TEST_CASE("A stage that does not hear that its time is up is killed soon after", "[isolation]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", "version: 1\nstages:\n  bad: {type: test.misbehave, how: loop}\n");
    const Finished finished = place.run({"run", "room.yaml", "--isolate", "bad", "--isolate-time", "1s"});
    CHECK(finished.code == 1);
    CHECK(contains(finished.err, "it exceeded the time limit of 1.0 s"));
    CHECK(finished.seconds >= 1);
    CHECK(finished.seconds < 4);
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

TEST_CASE("A process that a stage leaves behind ends with it", "[isolation]")
{
    Workplace place({"good", "misbehaving"});
    place.write("room.yaml", pipeline);
    const std::string how = GENERATE("leave_process", "leave_session");
    const Finished finished = place.run({"run", "room.yaml", "--set", "how=" + how});
    CHECK(finished.code == 0);
    // It would have the program mapped.
    bool left = false;
    for (const auto& process : fs::directory_iterator("/proc"))
    {
        std::ifstream maps(process.path() / "maps");
        for (std::string line; std::getline(maps, line);)
            left = left || line.find(place.root().string()) != std::string::npos;
    }
    CHECK_FALSE(left);
}

TEST_CASE("Limits that are not reached change nothing", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 8, step_ms: 60}\n");
    const Finished plain = place.run({"run", "room.yaml", "--json-log", "--store", "plain"});
    const Finished held = place.run({"run", "room.yaml", "--json-log", "--store", "held", "--isolate", "all", "--isolate-memory",
                                     "slow=1G", "--isolate-memory", "2G", "--isolate-time", "10m"});
    REQUIRE(plain.code == 0);
    REQUIRE(held.code == 0);
    const std::string object = told_of(plain, "slow", "object");
    CHECK(!object.empty());
    CHECK(told_of(held, "slow", "object") == object);
    CHECK(place.read("plain/objects/" + object + "/counted/table.json") ==
          place.read("held/objects/" + object + "/counted/table.json"));
    bool told = false;
    for (const auto& event : events(held.out))
        told = told || (event.at("event").as_string() == "progress" && event.at("metrics").find("loss") != nullptr);
    CHECK(told);
}

TEST_CASE("A stage with checkpoints goes on from where its time ended", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 60, step_ms: 40, log: log}\n");
    CHECK(place.run({"run", "room.yaml", "--isolate", "slow", "--isolate-time", "1s"}).code == 1);
    CHECK(place.log() == std::vector<std::string>{"slow from 0", "slow was stopped"});
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.log().size() == 3);
    CHECK(place.log().back() != "slow from 0");
}

TEST_CASE("Wrong limits are refused before anything runs", "[isolation]")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, log: log}\n");
    const auto refused = [&](const std::vector<std::string>& arguments, const std::string& text)
    {
        std::vector<std::string> all{"run", "room.yaml"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const Finished finished = place.run(all);
        CHECK(finished.code == 2);
        CHECK(contains(finished.out + finished.err, text));
    };
    refused({"--isolate", "slwo"}, "--isolate slwo: unknown stage 'slwo' (did you mean 'slow'?)");
    refused({"--isolate-time", "10m"}, "--isolate");
    refused({"--isolate", "slow", "--isolate-time", "soon"}, "--isolate-time soon: expected a time such as 90s, 10m or 1h30m");
    refused({"--isolate", "slow", "--isolate-memory", "4"},
            "--isolate-memory 4: expected an amount of memory such as 4G or 500M");
    refused({"--isolate", "slow", "--isolate-memory", "fast=4G"}, "the stage 'fast' is not isolated: add --isolate fast");
    CHECK(place.log().empty());
}

TEST_CASE("Amounts of memory and times are read as people write them", "[isolation]")
{
    using fresco::host::parse_memory_mb;
    using fresco::host::parse_seconds;
    CHECK(parse_memory_mb("4G") == 4096);
    CHECK(parse_memory_mb("1.5 GB") == 1536);
    CHECK(parse_memory_mb("512MiB") == 512);
    CHECK(parse_memory_mb("1048576k") == 1024);
    CHECK(parse_seconds("90") == 90);
    CHECK(parse_seconds("1h30m") == 5400);
    CHECK(parse_seconds("2 m 5s") == 125);
    for (const char* text : {"", "G", "4X", "4G4", "-4G", "nan", "1e3G", "0G", "inf"})
        CHECK_THROWS_AS(parse_memory_mb(text), fresco::Error);
    for (const char* text : {"", "m", "5d", "3s2m", "-1s", "0", "1m 2m", "inf"})
        CHECK_THROWS_AS(parse_seconds(text), fresco::Error);
}

TEST_CASE("Without words an isolated stage gets most of the machine and ten times what is expected", "[isolation]")
{
    fresco::host::Pipeline made;
    for (const char* name : {"quick", "long", "free"})
    {
        made.stages.emplace_back();
        made.stages.back().name = made.stages.back().own_name = name;
    }
    const auto limits = fresco::host::stage_limits({{"quick", "long"}, {}, {"quick=5m"}}, made, {{"quick", 2}, {"long", 100}});
    CHECK(limits.size() == 2);
    CHECK(limits.at("quick").seconds == 300);
    CHECK(limits.at("long").seconds == 1000);
    CHECK(limits.at("long").memory_mb == Approx(0.9 * fresco::host::machine_memory_mb()));
    CHECK(fresco::host::stage_limits({{"all"}, {}, {}}, made, {}).at("free").seconds == 600);
    // Of a matrix.
    made.stages[0].own_name = made.stages[1].own_name = "painted";
    CHECK(fresco::host::stage_limits({{"painted"}, {"quick=2G"}, {"painted=1m"}}, made, {}).at("quick").memory_mb == 2048);
    CHECK(fresco::host::stage_limits({{"painted"}, {}, {"painted=1m"}}, made, {}).at("long").seconds == 60);
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
    std::vector<std::string> got;
    for (std::string line; lines.next(line);)
        got.push_back(line);
    CHECK(got == std::vector<std::string>{"ab", "xxxxxx", "xxxxyz"});
    CHECK(lines.rest() == "last");
    writing.reset();
    CHECK_FALSE(lines.read_from(reading.get()));
}
