#include "program.h"

#include "base/text.h"
#include "run/sweep.h"

#include <algorithm>

namespace
{

using Words = std::vector<std::string>;

/// A source per scan, two pictures of each, and a stage that they all share.
const char* const sweep = R"(version: 1
vars: {scan: , picture: , how: error}
matrix: {scan: [1, 2], picture: {plain: 10, wild: 20}}
stages:
  scan_of: {type: test.source, value: "${scan}", log: log}
  common:  {type: test.source, value: 100, log: log}
  paint:   {type: test.add, input: {left: scan_of, right: common}, plus: "${picture}", wait_ms: 100, log: log}
  text:    {type: test.sink, input: paint, path: sum.txt, log: log}
  look:    {type: test.sink, input: scan_of, path: scan.txt, log: log}
)";

std::size_t occurrences(const Workplace& place, const std::string& beginning)
{
    const auto log = place.log();
    return static_cast<std::size_t>(
        std::count_if(log.begin(), log.end(), [&](const std::string& line) { return line.starts_with(beginning); }));
}

/// Name -> state, of sweep.json.
std::map<std::string, std::string> cells(const Workplace& place)
{
    std::map<std::string, std::string> result;
    const auto summary = fresco::parse_json(place.read("out/sweep.json"), "sweep.json");
    for (const auto& combination : summary.at("combinations").as_list())
        result[combination.at("name").as_string()] = combination.at("state").as_string();
    return result;
}

using Cells = std::map<std::string, std::string>;

/// The same, with a stage that fails where the picture is 1.
const char* const failing = R"(version: 1
vars: {picture: , how: error}
matrix: {how: [nothing, error], picture: [1, 2]}
stages:
  paint: {type: test.add, input: {left: base}, plus: "${picture}", wait_ms: 50, log: log}
  base:  {type: test.source, log: log}
  bad:   {type: test.fail, input: base, how: "${how}", log: log}
  text:  {type: test.sink, input: paint, path: sum.txt, log: log}
)";

}  // namespace

TEST_CASE("every combination runs, what they share runs once, and results are placed by their axes")
{
    Workplace place;
    place.write("sweep.yaml", sweep);
    const std::string jobs = GENERATE("1", "4");
    const Finished first = place.run({"run", "sweep.yaml", "--jobs", jobs, "--cores", "4"});
    INFO(first.err);
    REQUIRE(first.code == 0);
    CHECK(occurrences(place, "source") == 3);
    CHECK(occurrences(place, "add begins") == 4);
    CHECK(place.read("out/scan=1,plain/sum.txt") == "111.000000\n");
    CHECK(place.read("out/scan=1,wild/sum.txt") == "121.000000\n");
    CHECK(place.read("out/scan=2,plain/sum.txt") == "112.000000\n");
    CHECK(place.read("out/scan=2,wild/sum.txt") == "122.000000\n");
    CHECK(place.read("out/scan=1/scan.txt") == "1.000000\n");
    CHECK(place.read("out/scan=2/scan.txt") == "2.000000\n");
    CHECK(contains(first.out, "scan=2  wild     done"));
    CHECK(contains(first.out, "4 combinations: 4 done\nout/sweep.json\n"));
    const auto summary = fresco::parse_json(place.read("out/sweep.json"), "sweep.json");
    const auto& last = summary.at("combinations").as_list().at(3);
    CHECK(last.at("values").at("picture").as_string() == "wild");
    CHECK(last.at("files") == fresco::Value(fresco::Value::List{"scan=2,wild/sum.txt", "scan=2/scan.txt"}));
    // The common stage counts only for the first.
    CHECK(last.at("ran").as_int() == 5);
    CHECK(last.at("stages").as_list().size() == 5);

    place.clear_log();
    const Finished second = place.run({"run", "sweep.yaml"});
    CHECK(second.code == 0);
    CHECK(place.log().empty());
    CHECK(contains(second.out, "4 combinations: 4 done"));
    // One value more: what it shares is there.
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "picture=[10, 30]"}).code == 0);
    CHECK(occurrences(place, "source") == 0);
    CHECK(occurrences(place, "add begins") == 2);
    CHECK(place.read("out/scan=1,picture=30/sum.txt") == "131.000000\n");
}

TEST_CASE("the table and sweep.json have one time, that of a combination's own stages, also where nothing ran")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: }\nmatrix: {n: [1, 2]}\nstages:\n"
                              "  shared: {type: test.add, input: {left: one}, wait_ms: 1200}\n"
                              "  one: {type: test.source}\n"
                              "  own: {type: test.add, input: {left: shared}, plus: \"${n}\", wait_ms: 150}\n");
    for (int i = 0; i < 2; ++i)
    {
        const Finished finished = place.run({"run", "sweep.yaml"});
        REQUIRE(finished.code == 0);
        CHECK(contains(finished.out, "own time"));
        const auto summary = fresco::parse_json(place.read("out/sweep.json"), "sweep.json");
        for (const auto& combination : summary.at("combinations").as_list())
        {
            const double seconds = combination.at("own_seconds").as_double();
            CHECK(seconds >= 0.15);
            CHECK(seconds < 1.2);
            const std::size_t row = finished.out.find("\n" + combination.at("name").as_string() + " ") + 1;
            CHECK(contains(finished.out.substr(row, finished.out.find('\n', row) - row),
                           "  " + fresco::host::duration_text(seconds) + "  "));
        }
    }
}

TEST_CASE("combinations begin in their order, as many at once as are asked for")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: }\nmatrix: {n: [1, 2, 3, 4]}\nstages:\n"
                              "  one: {type: test.add, input: {left: two}, plus: \"${n}\", wait_ms: 150, log: log}\n"
                              "  two: {type: test.source}\n");
    REQUIRE(place.run({"run", "sweep.yaml", "--cores", "4"}).code == 0);
    Words alone;
    for (const char* n : {"1", "2", "3", "4"})
        for (const char* what : {"add begins ", "add ends "})
            alone.push_back(std::string(what) + n + ".000000");
    CHECK(place.log() == alone);
    place.clear_log();
    fs::remove_all(place.file(".fresco"));
    REQUIRE(place.run({"run", "sweep.yaml", "--cores", "4", "--jobs", "2"}).code == 0);
    const auto log = place.log();
    REQUIRE(log.size() == 8);
    int at_work = 0;
    int most = 0;
    for (const std::string& line : log)
        most = std::max(most, at_work += line.starts_with("add begins") ? 1 : -1);
    CHECK(most == 2);
}

TEST_CASE("stages that are expected to take more memory than there is wait for one another")
{
    Workplace place;
    // The cost() of test.source says 30 MB.
    place.write("room.yaml", R"(version: 1
stages:
  one: {type: test.source, value: 1, wait_ms: 300}
  two: {type: test.source, value: 2, wait_ms: 300}
)");
    const auto order = [&](const char* memory)
    {
        fs::remove_all(place.file(".fresco"));
        Words names;
        for (const auto& event : events(place.run({"run", "room.yaml", "--cores", "2", "--json-log", "--memory", memory}).out))
            if (const auto& name = event.at("event").as_string(); name == "begin" || name == "end")
                names.push_back(name);
        return names;
    };
    CHECK(order("50") == Words{"begin", "end", "begin", "end"});
    CHECK(order("5") == Words{"begin", "end", "begin", "end"});
    CHECK(order("500") == Words{"begin", "begin", "end", "end"});
}

TEST_CASE("a combination that fails ends the sweep, or the others go on by --keep-going")
{
    Workplace place;
    place.write("sweep.yaml", failing);
    const Finished stopped = place.run({"run", "sweep.yaml"});
    CHECK(stopped.code == 1);
    CHECK(contains(stopped.err, "stage bad@nothing (test.fail)"));
    // Of the first combination everything is there that does not need what failed.
    CHECK(place.read("out/picture=1/sum.txt") == "2.000000\n");
    CHECK_FALSE(fs::exists(place.file("out/picture=2")));
    CHECK(cells(place) == Cells{{"nothing,picture=1", "failed"},
                                {"nothing,picture=2", "failed"},
                                {"error,picture=1", "not run"},
                                {"error,picture=2", "not run"}});
    CHECK(occurrences(place, "fail") == 1);

    place.clear_log();
    const Finished going = place.run({"run", "sweep.yaml", "--keep-going"});
    CHECK(going.code == 1);
    CHECK(occurrences(place, "fail") == 2);
    CHECK(place.read("out/picture=2/sum.txt") == "3.000000\n");
    CHECK(contains(going.out, "at bad@error\n4 combinations: 4 failed\n"));
    CHECK(contains(going.err, "stage bad@error (test.fail)"));
}

TEST_CASE("an interrupted sweep goes on where it was")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: }\nmatrix: {n: [5, 6, 7]}\nstages:\n"
                              "  slow: {type: test.slow, steps: \"${n}\", step_ms: 60, log: log}\n"
                              "  text: {type: test.sink, input: slow, path: n.txt}\n");
    const auto run = place.start({"run", "sweep.yaml"});
    Workplace::wait_until([&] { return place.log().size() > 1; });
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    run->signal(SIGINT);
    const Finished stopped = run->wait();
    CHECK(stopped.code == 75);
    CHECK(cells(place) == Cells{{"n=5", "done"}, {"n=6", "interrupted"}, {"n=7", "not run"}});
    CHECK(contains(stopped.out, "3 combinations: 1 done, 1 interrupted, 1 not run"));
    REQUIRE(place.run({"run", "sweep.yaml"}).code == 0);
    const auto log = place.log();
    REQUIRE(log.size() == 5);
    CHECK(log[0] == "slow from 0");
    CHECK(log[3] != "slow from 0");
    CHECK(log[4] == "slow from 0");
    CHECK(place.read("out/n=6/n.txt") == "6.000000\n");
}

TEST_CASE("plan, check, graph, --until and --set know the matrix")
{
    Workplace place;
    place.write("sweep.yaml", sweep);
    CHECK(contains(place.run({"check", "sweep.yaml"}).err, "13 stages of 4 combinations, no problems"));
    CHECK(contains(place.run({"plan", "sweep.yaml"}).out, "paint@scan=1,wild "));
    CHECK(contains(place.run({"graph", "sweep.yaml"}).out, "\"paint@scan=2,plain\\ntest.add\""));
    REQUIRE(place.run({"run", "sweep.yaml", "--until", "scan_of"}).code == 0);
    CHECK(place.log().size() == 2);
    const Finished one = place.run({"run", "sweep.yaml", "--set", "scan=2", "--set", "picture=wild"});
    CHECK(one.code == 0);
    CHECK(cells(place) == Cells{{"scan=2,wild", "done"}});
    CHECK(place.read("out/scan=2,wild/sum.txt") == "122.000000\n");
    CHECK(occurrences(place, "add begins") == 1);
    CHECK(contains(place.run({"run", "sweep.yaml", "--set", "scan=3"}).err, "the axis 'scan' of the matrix has no value '3'"));
    // A sweep of one value still names what it made, and keeps what gc must not take.
    REQUIRE(place.run({"run", "sweep.yaml"}).code == 0);
    REQUIRE(place.run({"run", "sweep.yaml", "--set", "scan=1"}).code == 0);
    REQUIRE(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
    place.clear_log();
    REQUIRE(place.run({"run", "sweep.yaml"}).code == 0);
    CHECK(place.log().empty());
}

TEST_CASE("no two stages write one file, whichever way its folder came about")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: }\nmatrix: {n: {small: 1, large: 2}}\nstages:\n"
                              "  one:   {type: test.source, value: \"${n}\"}\n"
                              "  other: {type: test.source, value: 7}\n"
                              "  text:  {type: test.sink, input: one, path: f.txt}\n"
                              "  plain: {type: test.sink, input: other, path: small/f.txt}\n");
    const Finished finished = place.run({"run", "sweep.yaml", "--keep-going"});
    CHECK(finished.code == 1);
    CHECK(contains(finished.err, "would both write small/f.txt below --out: give one of them another path"));
    CHECK(place.read("out/large/f.txt") == "2.000000\n");
    // What they agree on is no conflict.
    CHECK(place.run({"run", "sweep.yaml", "--set", "other.value=1"}).code == 0);
    CHECK(place.read("out/small/f.txt") == "1.000000\n");
}

TEST_CASE("a stage's own sweep.json is kept")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: }\nmatrix: {n: [1, 2]}\nstages:\n"
                              "  one:   {type: test.source, value: \"${n}\"}\n"
                              "  other: {type: test.source, value: 7}\n"
                              "  text:  {type: test.sink, input: one, path: f.txt}\n"
                              "  plain: {type: test.sink, input: other, path: sweep.json}\n");
    const Finished finished = place.run({"run", "sweep.yaml"});
    CHECK(finished.code == 0);
    CHECK(place.read("out/sweep.json") == "7.000000\n");
    CHECK(contains(finished.err, "no summary of the combinations: the stage plain writes sweep.json itself"));
    CHECK(contains(finished.out, "2 combinations: 2 done\n"));
    CHECK_FALSE(fs::exists(place.file("out/sweep.html")));
}

TEST_CASE("options for a matrix are refused without one")
{
    Workplace place;
    place.write("room.yaml", "version: 1\nstages:\n  one: {type: test.source, log: log}\n");
    const Finished jobs = place.run({"run", "room.yaml", "--jobs", "2"});
    CHECK(jobs.code == 2);
    CHECK(contains(jobs.err, "--jobs: error: only for pipelines with a 'matrix'; room.yaml has none"));
    CHECK(contains(place.run({"run", "room.yaml", "--keep-going"}).err, "--keep-going: error: "));
    CHECK(place.log().empty());
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK_FALSE(fs::exists(place.file("out/sweep.json")));
}
