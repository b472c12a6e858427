#include "program.h"

#include "base/machine.h"
#include "base/process.h"
#include "run/stage_limits.h"
#include <fresco/error.h>

#include <fcntl.h>

// More of what plugins do to their process, to others and to the machine: prove_hostile_plugins.

using namespace fresco::host;

TEST_CASE("Limits that are not reached change nothing", "[isolation]")
{
    RoomPlace place("\n  slow: {type: test.slow, steps: 8, step_ms: 60}\n");
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
    RoomPlace place("\n  slow: {type: test.slow, steps: 60, step_ms: 40, log: log}\n");
    // So slow that it has begun, and is not done, when the time ends on a busy machine, too.
    place.run({"run", "room.yaml", "--isolate", "slow", "--isolate-time", "4s", "--set", "slow.step_ms=500"}, 1);
    CHECK(place.log() == Words{"slow from 0", "slow was stopped"});
    place.make();
    CHECK(place.log().size() == 3);
    CHECK(place.log().back() != "slow from 0");
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
    CHECK_THROWS_AS(parse_seconds(std::string(1'000'000, '9')), fresco::Error);
}

TEST_CASE("Without words an isolated stage gets most of the machine and ten times what was measured", "[isolation]")
{
    Pipeline made;
    for (const char* name : {"quick", "long", "free"})
    {
        made.stages.emplace_back();
        made.stages.back().name = made.stages.back().own_name = name;
    }
    const auto limits = stage_limits({{"all"}, {}, {}}, made, {{"quick", 2}, {"long", 100}});
    CHECK(limits.at("quick").seconds == 600);
    CHECK(limits.at("long").seconds == 1000);
    CHECK(limits.at("free").seconds == 3600);
    CHECK(limits.at("long").memory_mb == Approx(0.9 * machine_memory_mb()));
    // A stage's own goes before that of all.
    const auto both = stage_limits({{"quick", "long"}, {}, {"quick=5m", "1m"}}, made, {});
    CHECK(both.size() == 2);
    CHECK(both.at("quick").seconds == 300);
    CHECK(both.at("long").seconds == 60);
    // A stage of a matrix.
    made.stages[0].own_name = made.stages[1].own_name = "painted";
    CHECK(stage_limits({{"painted"}, {"quick=2G"}, {"painted=1m"}}, made, {}).at("quick").memory_mb == 2048);
    CHECK(stage_limits({{"painted"}, {}, {"painted=1m"}}, made, {}).at("long").seconds == 60);
}
