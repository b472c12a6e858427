#include "program.h"

#include "base/file_lock.h"
#include "base/records.h"

#include <algorithm>

// One store for several machines, several stores for one.

namespace
{

const char* const slow = "version: 1\nstages:\n  slow: {type: test.slow, steps: 30, step_ms: 40, log: log}\n";

fs::path only_file_in(const fs::path& folder, const std::string& extension)
{
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == extension)
            return entry.path();
    FAIL("nothing in " << folder << " ends with " << extension);
    return {};
}

std::size_t count_in(const fs::path& folder)
{
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

/// A run that was killed in the middle of its stage, which had a checkpoint.
void run_and_kill(Workplace& place)
{
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    run->signal(SIGKILL);
    run->wait();
}

}  // namespace

TEST_CASE("Who waits for a result says who makes it, and gets it soon after")
{
    Workplace place;
    place.write("room.yaml", slow);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const fs::path record = only_file_in(place.file(".fresco/keys"), ".json");
    const std::string kept = fresco::read_text_file(record);
    fs::remove(record);
    fs::rename(place.file(".fresco/objects"), place.file("objects"));
    place.clear_log();
    fresco::host::FileLock lock(place.file(".fresco/locks") / record.stem());
    REQUIRE(lock.try_exclusive());
    lock.sign();
    const auto run = place.start({"run", "room.yaml"});
    const std::string expected =
        "slow: waiting for another run that makes the same result: process " + std::to_string(getpid()) + " on ";
    const fs::path err = place.root() / "err2";
    Workplace::wait_until([&] { return fs::exists(err) && fresco::read_text_file(err).find(expected) != std::string::npos; });
    fs::remove(place.file(".fresco/objects"));
    fs::rename(place.file("objects"), place.file(".fresco/objects"));
    fresco::write_file(record, kept);
    lock = fresco::host::FileLock();
    const auto begin = std::chrono::steady_clock::now();
    CHECK(run->wait().code == 0);
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(3));
    CHECK(place.log().empty());
}

#ifndef __SANITIZE_ADDRESS__
TEST_CASE("A result that another machine made while this one waited is found, although it was not there before")
{
    Workplace place;
    place.write("room.yaml", slow);
    const auto first = place.start({"run", "room.yaml", "--out", "first"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    place.environment["LD_PRELOAD"] = (fs::path(FRESCO_TEST_PLUGINS) / "lacking/lacking.so").string();
    place.environment["LACKING_NAMES"] = "1";
    CHECK(place.run({"run", "room.yaml"}).code == 0);
    CHECK(first->wait().code == 0);
    CHECK(place.log() == std::vector<std::string>{"slow from 0"});
}
#endif

TEST_CASE("A checkpoint of another type of processor is not gone on with, and that is said")
{
    Workplace place;
    place.write("room.yaml", slow);
    run_and_kill(place);
    const fs::path file = only_file_in(place.file(".fresco/checkpoints"), ".dependencies");
    fresco::Value record = fresco::host::read_record(file);
    record.as_map().pop_back();
    bool same = false;
    SECTION("the same")
    {
        same = true;
    }
    SECTION("another")
    {
        record.set("place", fresco::Value::Map{{"features", "abacus"}, {"gpus", fresco::Value::List{}}});
    }
    fresco::host::write_record(file, record);
    place.clear_log();
    const auto plan = fresco::parse_json(place.run({"plan", "room.yaml", "--json"}).out);
    const std::string reason = plan.at("stages").as_list().at(0).at("reason").as_string();
    const Finished finished = place.run({"run", "room.yaml"});
    REQUIRE(finished.code == 0);
    if (same)
    {
        CHECK(contains(reason, "interrupted at"));
        CHECK(place.log().back() != "slow from 0");
        return;
    }
    const std::string words = "begins again: its checkpoint was made on another type of processor (abacus; here ";
    CHECK(contains(reason, words));
    CHECK(contains(finished.err, words));
    CHECK(place.log().back() == "slow from 0");
}

TEST_CASE("A store lends its results to others, which copy what they need")
{
    Workplace place;
    place.write("extra", "123");
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source, file: extra, log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
  text:   {type: test.sink, input: add, path: x.txt, log: log}
)");
    REQUIRE(place.run({"run", "room.yaml", "--store", "slow"}).code == 0);
    place.clear_log();
    const std::vector<std::string> lent{"run",  "room.yaml", "--store", "fast",      "--upstream",
                                        "slow", "--out",     "other",   "--json-log"};
    SECTION("only the end of the pipeline is copied")
    {
        const auto plan =
            fresco::parse_json(place.run({"plan", "room.yaml", "--store", "fast", "--upstream", "slow", "--json"}).out);
        const auto& text = plan.at("stages").as_list().at(2);
        CHECK_FALSE(text.at("runs").as_bool());
        CHECK(text.at("reason").as_string() == "copied from the upstream store");
        const Finished run = place.run(lent);
        INFO(run.err);
        REQUIRE(run.code == 0);
        CHECK(states(run)["text"] == "stored");
        CHECK(place.log().empty());
        CHECK(place.read("other/x.txt") == "5.000000\n");
        CHECK(count_in(place.file("fast/objects")) == 1);
        CHECK(place.run({"store", "verify", "--store", "fast"}).code == 0);
        SECTION("and the rest where something else is made of it")
        {
            std::vector<std::string> changed = lent;
            changed.insert(changed.end(), {"--set", "text.copies=1"});
            REQUIRE(place.run(changed).code == 0);
            CHECK(place.log().size() == 1);
            CHECK(count_in(place.file("fast/objects")) == 3);
        }
    }
    SECTION("a damaged result is made here")
    {
        for (const auto& entry : fs::recursive_directory_iterator(place.file("slow/objects")))
            if (entry.path().filename() == "x.txt")
                std::ofstream(entry.path()) << "9.000000\n";
        const Finished run = place.run(lent);
        INFO(run.err);
        REQUIRE(run.code == 0);
        CHECK(contains(run.out, "stage text runs instead"));
        CHECK(place.log().size() == 1);
        CHECK(place.read("other/x.txt") == "5.000000\n");
    }
    SECTION("all are copied")
    {
        const Finished copied = place.run({"store", "copy", "slow", "fast", "--json"});
        REQUIRE(copied.code == 0);
        CHECK(fresco::parse_json(copied.out).at("copied").as_int() == 3);
        REQUIRE(place.run({"run", "room.yaml", "--store", "fast", "--out", "other"}).code == 0);
        CHECK(place.log().empty());
    }
    CHECK(place.run({"run", "room.yaml", "--upstream", "nowhere"}).code == 3);
    CHECK(place.run({"store", "copy", "nowhere", "fast"}).code == 3);
}

TEST_CASE("What lies below an input is the same wherever the input is")
{
    Workplace place;
    place.write("one/room/a", "12");
    place.write("room.yaml", R"(version: 1
inputs: {data: one}
stages:
  source: {type: test.source, folder: "${data}/room", log: log}
  text:   {type: test.sink, input: source, path: x.txt, log: log}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    REQUIRE(place.log().size() == 2);
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/keys")))
        CHECK(fresco::read_text_file(entry.path()).find(place.work().string()) == std::string::npos);
    fs::rename(place.file("one"), place.file("two"));
    place.clear_log();
    const std::vector<std::string> again{"run", "room.yaml", "--set", "data=two"};
    REQUIRE(place.run(again).code == 0);
    CHECK(place.log().empty());

    // In a store of its own the result has the same name.
    REQUIRE(place.run({"run", "room.yaml", "--set", "data=two", "--store", "other"}).code == 0);
    std::set<std::string> names;
    for (const char* store : {".fresco", "other"})
        for (const auto& entry : fs::directory_iterator(place.file(store) / "objects"))
            names.insert(entry.path().filename().string());
    CHECK(names.size() == 2);

    place.write("two/room/a", "123");
    place.clear_log();
    REQUIRE(place.run(again).code == 0);
    CHECK(place.log().size() == 2);
    CHECK(place.read("out/x.txt") == "4.000000\n");
    // Not named under `inputs`: its place counts.
    place.write("plain.yaml",
                "version: 1\nvars: {data: two}\nstages:\n  source: {type: test.source, folder: \"${data}/room\", log: log}\n");
    place.clear_log();
    REQUIRE(place.run({"run", "plain.yaml"}).code == 0);
    CHECK(place.log().size() == 1);
}

TEST_CASE("What lies beside an input is looked at where the input is")
{
    Workplace place;
    place.write("one/data/a", "12");
    place.write("two/data/a", "12");
    place.write("one/b", "5");
    place.write("two/b", "6");
    place.write("room.yaml", R"(version: 1
inputs: {data: one/data}
stages:
  source: {type: test.source, file: "${data}/a", beside: ../b, log: log}
  text:   {type: test.sink, input: source, path: x.txt, log: log}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "8.000000\n");
    REQUIRE(place.run({"run", "room.yaml", "--set", "data=two/data"}).code == 0);
    CHECK(place.read("out/x.txt") == "9.000000\n");
}
