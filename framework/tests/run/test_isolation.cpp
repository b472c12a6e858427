#include "program.h"

#include "base/process.h"
#include <fcntl.h>

// More of what plugins do to their process, to others and to the machine: prove_hostile_plugins.

using namespace fresco::host;

TEST_CASE("Limits that are not reached change nothing", "[isolation]")
{
    RoomPlace place("\n  slow: {type: test.slow, steps: 8, step_ms: 60}\n");
    const Finished plain = place.make({"--json-log", "--store", "plain"});
    const Finished held = place.make({"--json-log", "--store", "held", "--stage-memory", "2G", "--stage-time", "10m"});
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
    place.run({"run", "room.yaml", "--stage-time", "4s", "--set", "slow.step_ms=500"}, 1);
    CHECK(place.log() == Words{"slow from 0", "slow was stopped"});
    place.make();
    CHECK(place.log().size() == 3);
    CHECK(place.log().back() != "slow from 0");
}
