#include "program.h"

#include "base/records.h"

// One store for several machines.

namespace
{

const char* const slow = "\n  slow: {type: test.slow, steps: 30, step_ms: 40, log: log}\n";

}  // namespace

TEST_CASE("Two runs at once make a result once, also on two machines; the one that waits says which process makes it")
{
    RoomPlace place(slow);
    const auto first = place.start({"run", "room.yaml", "--out", "first"});
    wait_until([&] { return !place.log().empty(); });
    const pid_t maker = first->a_child();
    REQUIRE(kill(maker, SIGSTOP) == 0);
#ifndef __SANITIZE_ADDRESS__
    // A network file system remembers that the result was not there before.
    place.environment["LD_PRELOAD"] = GENERATE(fs::path(), test_plugin("lacking/lacking.so"));
    place.environment["LACKING_NAMES"] = "1";
#endif
    const auto second = place.start({"run", "room.yaml"});
    const std::string waiting = "slow: waiting for another run that makes the same result: process ";
    wait_until([&] { return second->says(waiting + std::to_string(maker) + " on "); });
    kill(maker, SIGCONT);
    CHECK((first->wait().code == 0 && second->wait().code == 0));
    CHECK(place.log() == Words{"slow from 0"});
}

TEST_CASE("A checkpoint of another type of processor is not gone on with, and that is said")
{
    RoomPlace place(slow);
    {
        const auto run = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=400"});
        // Then it has a checkpoint.
        wait_until([&] { return std::ranges::count(run->out(), '\n') > 4; });
        run->signal(SIGKILL);
        run->wait();
    }
    fs::path file;
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/checkpoints")))
        if (entry.path().extension() == ".dependencies")
            file = entry.path();
    fresco::Value record = fresco::host::read_record(file);
    record.as_map().pop_back();
    const bool same = GENERATE(true, false);
    if (!same)
        record.set("place", fresco::Value::Map{{"features", "abacus"}, {"gpus", fresco::Value::List{}}});
    fresco::host::write_record(file, record);
    place.clear_log();
    const std::string plan = place.run({"plan", "room.yaml", "--json"}).out;
    const Finished finished = place.make();
    const std::string words = "begins again: its checkpoint was made on another type of processor (abacus; here ";
    CHECK(contains(plan, same ? "interrupted at" : words));
    CHECK((finished.err.find(words) == std::string::npos) == same);
    CHECK((place.log().back() != "slow from 0") == same);
}
