#include "program.h"

#include "store/store.h"

namespace
{

std::string only_object_with(const Workplace& place, const std::string& output)
{
    for (const auto& entry : fs::directory_iterator(place.file(".fresco/objects")))
        if (fs::exists(entry.path() / output))
            return entry.path().filename().string();
    return "";
}

fresco::Value manifest_with(const Workplace& place, const std::string& output)
{
    return fresco::parse_json(place.read(".fresco/objects/" + only_object_with(place, output) + "/manifest.json"));
}

}  // namespace

TEST_CASE("Every failure has an error message and the right exit code, and publishes nothing")
{
    const std::map<std::string, std::pair<int, std::string>> ways{
        {"error", {1, "three vertices expected"}},
        {"missing", {3, "weights.safetensors: no such file"}},
        {"exception", {1, "unexpected error, please report it to the plugin's author: index 7 of 3"}},
        {"unknown", {1, "something other than an exception"}},
        {"crash", {1, "Segmentation fault"}},
        {"exit", {1, "ended with exit code 0 before the stage was done"}},
        {"memory", {1, "not enough memory"}},
        {"full", {1, "free some space"}},
        {"nothing", {1, "output"}},
        {"link", {1, "output/link"}}};
    Workplace place;
    for (const auto& [how, expected] : ways)
    {
        INFO(how);
        place.write("room.yaml", "version: 1\nstages:\n  bad: {type: test.fail, how: " + how + "}\n");
        const Finished finished = place.run({"run", "room.yaml"});
        CHECK(finished.code == expected.first);
        CHECK(contains(finished.err, expected.second));
        CHECK(contains(finished.err, "room.yaml:3:3: error: stage bad (test.fail)"));
        CHECK(fs::is_empty(place.file(".fresco/objects")));
    }
    CHECK(contains(place.run({"run", "room.yaml", "--set", "bad.how=crash"}).err, "about to fail"));
}

TEST_CASE("An output that is left out leaves an optional input empty, and stops a stage that needs it")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  maybe: {type: test.maybe, log: log}
  add:   {type: test.add, input: {left: maybe.always, right: maybe.table}}
  text:  {type: test.sink, input: add, path: sum.txt}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/sum.txt") == "8.000000\n");
    const Finished without = place.run({"run", "room.yaml", "--set", "maybe.made=false"});
    INFO(without.err);
    REQUIRE(without.code == 0);
    CHECK(place.read("out/sum.txt") == "1.000000\n");
    // It is stored as it is.
    place.clear_log();
    CHECK(place.run({"run", "room.yaml", "--set", "maybe.made=false"}).code == 0);
    CHECK(place.log().empty());

    place.write("needs.yaml", "version: 1\nstages:\n  maybe: {type: test.maybe, made: false}\n"
                              "  text: {type: test.sink, input: maybe.table}\n");
    const Finished needs = place.run({"run", "needs.yaml"});
    CHECK(needs.code == 3);
    CHECK(contains(needs.err, "needs.yaml:4:3: error: stage text (test.sink)"));
    CHECK(contains(needs.err, "input 'table' is empty: maybe.table is optional, and that stage made none"));
}

TEST_CASE("The manifest says how a result came about")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  source: {type: test.source, value: 3}\n");
    REQUIRE(place.run({"run", "room.yaml", "--cores", "1"}).code == 0);
    const auto manifest = manifest_with(place, "table");
    CHECK(manifest.at("type").as_string() == "test.source");
    CHECK(manifest.at("options").at("value").as_double() == 3);
    CHECK(manifest.at("report").at("threads").as_int() == 1);
    CHECK(manifest.at("versions").at("Testlib").as_string() == "1.2.3");
    CHECK(manifest.at("messages").as_list().size() == 1);
    CHECK(manifest.at("memory_mb").as_double() > 1);
    CHECK(manifest.find("processor") != nullptr);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
}

TEST_CASE("A figure that is not a number is null in progress and manifest")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  mean: {type: test.unmeasured}\n");
    const Finished finished = place.run({"run", "room.yaml", "--json-log"});
    INFO(finished.out);
    REQUIRE(finished.code == 0);
    const auto report = manifest_with(place, "table").at("report");
    CHECK(report.at("mean").is_null());
    CHECK(report.at("ranges").at("list").as_list().at(0).as_double() == 1.5);
    CHECK(report.at("ranges").at("list").as_list().at(1).is_null());
    CHECK(report.at("ranges").at("count").as_int() == 3);
    std::vector<fresco::Value> progress;
    for (const auto& event : events(finished.out))
        if (event.at("event").as_string() == "progress")
            progress.push_back(event);
    REQUIRE(progress.size() == 1);
    CHECK(progress[0].at("done").as_double() == 1);
    CHECK(progress[0].at("metrics").at("loss").is_null());
}

TEST_CASE("Equal components are one object, a file goes through its reader")
{
    Workplace place;
    place.write("a.number", "7");
    place.write("room.yaml", R"(version: 1
stages:
  scale: {type: test.scale, input: {table: {file: a.number}}, log: log}
  text:  {type: test.sink, input: scale, path: x.txt}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "28.000000\n");
    CHECK(manifest_with(place, "scaled").at("report").at("shared").as_bool());

    REQUIRE(place.run({"run", "room.yaml", "--set", "scale.second={type: test.factor, factor: 3}"}).code == 0);
    CHECK(place.read("out/x.txt") == "42.000000\n");
    place.write("a.number", "8");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "32.000000\n");
    place.write("a.number", "7");
    place.clear_log();
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.read("out/x.txt") == "28.000000\n");
    CHECK(place.log().empty());
}

TEST_CASE("A damaged result is named and made again in the same run")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source, value: 4, log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
  text:   {type: test.sink, input: add, path: x.txt, log: log}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const std::string source = only_object_with(place, "table");
    place.write(".fresco/objects/" + source + "/table/table.json", R"({"columns":["value"],"rows":[[9]]})");
    place.clear_log();
    const Finished repaired = place.run({"run", "room.yaml", "--set", "add.plus=2"});
    CHECK(repaired.code == 0);
    CHECK(contains(repaired.err, source));
    CHECK(contains(repaired.err, "damaged"));
    CHECK(place.read("out/x.txt") == "6.000000\n");
    CHECK(place.log().size() == 4);

    SECTION("also where the damage shows when a file is put back below --out")
    {
        const std::string sink = only_object_with(place, "files");
        place.write(".fresco/objects/" + sink + "/files/x.txt", "scribble");
        fs::remove_all(place.file("out"));
        place.clear_log();
        CHECK(place.run({"run", "room.yaml"}).code == 0);
        CHECK(fs::exists(place.file("out/x.txt")));
        CHECK(place.read("out/x.txt") != "scribble");
    }
    SECTION("store verify finds it too")
    {
        CHECK(place.run({"store", "verify"}).code == 0);
        place.write(".fresco/objects/" + source + "/table/table.json", "scribble");
        const Finished verified = place.run({"store", "verify"});
        CHECK(verified.code == 1);
        CHECK(contains(verified.out, source));
        CHECK(place.run({"store", "verify", "--remove"}).code == 0);
        CHECK(place.run({"store", "verify"}).code == 0);
    }
}

TEST_CASE("A damaged result that another run is already making again is left to that run")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source, value: 4, log: log}
  add:    {type: test.add, input: {left: source}, plus: 1, log: log}
)");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const std::string table = ".fresco/objects/" + only_object_with(place, "table") + "/table/table.json";
    const std::string whole = place.read(table);
    place.write(table, "scribble");
    place.clear_log();
    // The other run: at work on the key until the result is whole again.
    fresco::host::FileLock other(place.file(".fresco/locks/" + manifest_with(place, "table").at("key").as_string()));
    REQUIRE(other.try_exclusive());
    const auto end_other_run = [&]
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(1500));
        place.write(table, whole);
        other = fresco::host::FileLock();
    };
    SECTION("by a run that found the damage")
    {
        const auto run = place.start({"run", "room.yaml", "--set", "add.plus=2"});
        end_other_run();
        CHECK(run->wait().code == 0);
        CHECK(place.log() == std::vector<std::string>{"add begins 2.000000", "add ends 2.000000"});
    }
    SECTION("by store verify --remove")
    {
        const auto verify = place.start({"store", "verify", "--remove"});
        end_other_run();
        const Finished verified = verify->wait();
        CHECK(verified.code == 0);
        CHECK(contains(verified.out, "a run has since recomputed it"));
        CHECK(place.read(table) == whole);
    }
}

TEST_CASE("A checkpoint made from other outside files is not used")
{
    Workplace place;
    place.write("a.number", "1");
    place.write("room.yaml", R"(version: 1
stages:
  slow: {type: test.slow, input: {start: {file: a.number}}, steps: 30, step_ms: 40, log: log}
)");
    {
        const auto run = place.start({"run", "room.yaml"});
        Workplace::wait_until([&] { return !place.log().empty(); });
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        run->signal(SIGKILL);
        run->wait();
    }
    place.write("a.number", "2");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(place.log().back() == "slow from 0");
}

TEST_CASE("A killed host takes its stages with it")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 1000, step_ms: 20, log: log}\n");
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return !place.log().empty(); });
    run->signal(SIGKILL);
    CHECK(run->wait().code == -SIGKILL);
    const auto step = [&]
    {
        for (const auto& entry : fs::recursive_directory_iterator(place.file(".fresco/checkpoints")))
            if (entry.path().filename() == "step")
                return fresco::read_text_file(entry.path());
        return std::string();
    };
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const std::string before = step();
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    CHECK(step() == before);
}
