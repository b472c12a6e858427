#include "program.h"

#include "base/records.h"

// One store for several machines, several stores for one.

namespace
{

const char* const slow = "version: 1\nstages:\n  slow: {type: test.slow, steps: 30, step_ms: 40, log: log}\n";

}  // namespace

#ifndef __SANITIZE_ADDRESS__
TEST_CASE("A result that another machine made while this one waited is found, although it was not there before")
{
    Workplace place;
    place.write("room.yaml", slow);
    const auto first = place.start({"run", "room.yaml", "--out", "first"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    place.environment["LD_PRELOAD"] = test_plugin("lacking/lacking.so");
    place.environment["LACKING_NAMES"] = "1";
    place.make();
    CHECK(first->wait().code == 0);
    CHECK(place.log() == Words{"slow from 0"});
}
#endif

TEST_CASE("A checkpoint of another type of processor is not gone on with, and that is said")
{
    Workplace place;
    place.write("room.yaml", slow);
    {
        const auto run = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=400"});
        // Then it has a checkpoint.
        Workplace::wait_until([&] { return std::ranges::count(run->out(), '\n') > 4; });
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

TEST_CASE("A store lends its results to others, which copy what they need")
{
    Workplace place;
    place.write("extra", "123");
    place.write_stages(R"(
  source: {type: test.source, file: extra, log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
  text:   {type: test.sink, input: add, path: x.txt, log: log}
)");
    place.make({"--store", "slow"});
    place.clear_log();
    const Words lent{"--store", "fast", "--upstream", "slow", "--out", "other", "--json-log"};
    SECTION("only the end of the pipeline is copied, and the rest where something else is made of it")
    {
        const auto plan =
            fresco::parse_json(place.run({"plan", "room.yaml", "--store", "fast", "--upstream", "slow", "--json"}).out);
        const auto& text = plan.at("stages").as_list().at(2);
        CHECK_FALSE(text.at("runs").as_bool());
        CHECK(text.at("reason").as_string() == "copied from the upstream store");
        CHECK(outcomes(place.make(lent))["text"] == "stored");
        CHECK(place.log().empty());
        CHECK(place.read("other/x.txt") == "5.000000\n");
        CHECK(place.objects("fast").size() == 1);
        Words changed = lent;
        changed.insert(changed.end(), {"--set", "text.copies=1"});
        place.make(changed);
        CHECK(place.log().size() == 1);
        CHECK(place.objects("fast").size() == 3);
        CHECK(place.run({"store", "verify", "--store", "fast"}).code == 0);
    }
    SECTION("a damaged result is made here")
    {
        for (const auto& object : place.objects("slow"))
            if (fs::exists(object / "files/x.txt"))
                std::ofstream(object / "files/x.txt") << "9.000000\n";
        CHECK(contains(place.make(lent).out, "stage text runs instead"));
        CHECK(place.log().size() == 1);
        CHECK(place.read("other/x.txt") == "5.000000\n");
    }
    SECTION("all are copied")
    {
        const Finished copied = place.run({"store", "copy", "slow", "fast", "--json"});
        CHECK(fresco::parse_json(copied.out).at("copied").as_int() == 3);
        place.make({"--store", "fast", "--out", "other"});
        CHECK(place.log().empty());
        CHECK(place.run({"run", "room.yaml", "--upstream", "nowhere"}).code == 3);
        CHECK(place.run({"store", "copy", "nowhere", "fast"}).code == 3);
    }
}

TEST_CASE("What lies below an input is the same wherever the input is; what lies beside it is looked at there")
{
    Workplace place;
    place.write("one/room/a", "12");
    place.write("one/b", "5");
    place.write("other/b", "6");
    place.write("room.yaml", R"(version: 1
inputs: {data: one/room}
stages:
  source: {type: test.source, folder: "${data}", log: log}
  text:   {type: test.sink, input: source, path: x.txt, log: log}
  beside: {type: test.source, file: "${data}/a", beside: ../b}
  other:  {type: test.sink, input: beside, path: y.txt}
)");
    place.make();
    CHECK(place.read("out/y.txt") == "8.000000\n");
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/keys")))
        if (const std::string record = fresco::read_text_file(entry.path()); record.find("/b\"") == std::string::npos)
            CHECK(record.find(place.work().string()) == std::string::npos);
    place.clear_log();
    fs::rename(place.file("one/room"), place.file("other/room"));
    const Words moved{"--set", "data=other/room"};
    place.make(moved);
    CHECK(place.log().empty());
    CHECK(place.read("out/y.txt") == "9.000000\n");

    // In a store of its own the result has the same name.
    place.make({"--set", "data=other/room", "--store", "second", "--until", "text"});
    for (const auto& object : place.objects("second"))
        CHECK(fs::exists(place.file(".fresco/objects") / object.filename()));

    place.write("other/room/a", "123");
    place.clear_log();
    place.make(moved);
    CHECK(place.log().size() == 2);
    CHECK(place.read("out/x.txt") == "4.000000\n");
    // Not named under `inputs`: its place counts.
    place.write("room.yaml",
                "version: 1\nvars: {data: other}\nstages:\n  source: {type: test.source, folder: \"${data}/room\", log: log}\n");
    place.clear_log();
    place.make();
    CHECK(place.log().size() == 1);
}
