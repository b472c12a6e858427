#include "program.h"

#include "base/text.h"

namespace
{

using Cells = std::map<std::string, std::string>;

/// A source per scan, two pictures of each, and a stage that they all share.
const char* const sweep = R"(version: 1
vars: {scan: , picture: , how: error}
matrix: {scan: [1, 2], picture: {plain: 10, wild: 20}}
stages:
  scan_of: {type: test.source, value: "${scan}", log: log}
  common:  {type: test.source, value: 100, log: log}
  paint:   {type: test.add, input: {left: scan_of, right: common}, plus: "${picture}", log: log}
  text:    {type: test.sink, input: paint, path: sum.txt, log: log}
  look:    {type: test.sink, input: scan_of, path: scan.txt, log: log}
)";

/// A matrix of `n` with these stages.
std::string matrix(const std::string& values, const std::string& stages)
{
    return "version: 1\nvars: {n: }\nmatrix: {n: " + values + "}\nstages:\n" + stages;
}

fresco::Value::List combinations(const Workplace& place)
{
    return place.read_json("out/sweep.json").at("combinations").as_list();
}

/// Name -> state, of sweep.json.
Cells cells(const Workplace& place)
{
    Cells result;
    for (const auto& combination : combinations(place))
        result[combination.at("name").as_string()] = combination.at("state").as_string();
    return result;
}

}  // namespace

TEST_CASE("every combination runs, what they share runs once, and results are placed by their axes")
{
    RoomPlace place(sweep);
    const std::string jobs = GENERATE("1", "4");
    const Finished first = place.make({"--jobs", jobs, "--cores", "4"});
    CHECK(place.logged("source") == 3);
    CHECK(place.logged("add begins") == 4);
    for (const auto& [file, text] : {std::pair("1,plain/sum", "111"),
                                     {"1,wild/sum", "121"},
                                     {"2,plain/sum", "112"},
                                     {"2,wild/sum", "122"},
                                     {"1/scan", "1"},
                                     {"2/scan", "2"}})
        CHECK(place.read("out/scan=" + std::string(file) + ".txt") == std::string(text) + ".000000\n");
    CHECK(contains(first.out, "scan=2  wild     done"));
    CHECK(contains(first.out, "4 combinations: 4 done\nout/sweep.json\n"));
    const auto last = combinations(place).at(3);
    CHECK(last.at("files") == fresco::Value(fresco::Value::List{"scan=2,wild/sum.txt", "scan=2/scan.txt"}));
    CHECK(last.at("ran").as_int() == 5);

    place.clear_log();
    CHECK(contains(place.make().out, "4 combinations: 4 done"));
    CHECK(place.log().empty());
    // One value more: what it shares is there.
    place.make({"--set", "picture=[10, 30]"});
    CHECK(place.logged("source") == 0);
    CHECK(place.logged("add begins") == 2);
    CHECK(place.read("out/scan=1,picture=30/sum.txt") == "131.000000\n");
}

TEST_CASE("the table and sweep.json have one time, that of a combination's own stages, also where nothing ran")
{
    RoomPlace place(matrix("[1, 2]", "  shared: {type: test.add, input: {left: one}, wait_ms: 300}\n"
                                     "  one: {type: test.source}\n"
                                     "  own: {type: test.add, input: {left: shared}, plus: \"${n}\", wait_ms: 150}\n"));
    for (int i = 0; i < 2; ++i)
    {
        const Finished finished = place.make();
        for (const auto& combination : combinations(place))
        {
            const std::string& name = combination.at("name").as_string();
            const double seconds = combination.at("own_seconds").as_double();
            const auto stages = place.read_json("out/" + name + "/run.json").at("stages").as_list();
            CHECK(stages.back().at("seconds").as_double() == Approx(seconds));
            const auto is_row = [&](const std::string& line) { return line.starts_with(name + " "); };
            const Words lines = lines_of(finished.out);
            CHECK(contains(*std::ranges::find_if(lines, is_row), "  " + fresco::host::duration_text(seconds) + "  "));
        }
    }
}

TEST_CASE("combinations begin in their order, as many at once as are asked for")
{
    RoomPlace place(matrix("[1, 2, 3, 4]", "  one: {type: test.add, input: {left: two}, plus: \"${n}\", wait_ms: 150, log: log}\n"
                                           "  two: {type: test.source}\n"));
    place.make({"--cores", "4"});
    Words alone;
    for (const char* n : {"1", "2", "3", "4"})
        for (const char* what : {"add begins ", "add ends "})
            alone.push_back(std::string(what) + n + ".000000");
    CHECK(place.log() == alone);
    place.clear_log();
    place.make({"--cores", "4", "--jobs", "2", "--store", "other", "--set", "one.wait_ms=0", "--set", "one.together=2"});
    int at_work = 0;
    int most = 0;
    for (const std::string& line : place.log())
        most = std::max(most, at_work += line.starts_with("add begins") ? 1 : -1);
    CHECK(most == 2);
}

TEST_CASE("a combination that fails ends the sweep, or the others go on by --keep-going")
{
    RoomPlace place(R"(version: 1
vars: {picture: , how: error}
matrix: {how: [nothing, error], picture: [1, 2]}
stages:
  paint: {type: test.add, input: {left: base}, plus: "${picture}", wait_ms: 50, log: log}
  base:  {type: test.source, log: log}
  bad:   {type: test.fail, input: base, how: "${how}", log: log}
  text:  {type: test.sink, input: paint, path: sum.txt, log: log}
)");
    CHECK(contains(place.run({"run", "room.yaml"}, 1).err, "stage bad@nothing (test.fail)"));
    // The first combination has all results that do not need the failed one.
    CHECK(place.read("out/picture=1/sum.txt") == "2.000000\n");
    CHECK_FALSE(fs::exists(place.file("out/picture=2")));
    CHECK(cells(place) == Cells{{"nothing,picture=1", "failed"},
                                {"nothing,picture=2", "failed"},
                                {"error,picture=1", "not run"},
                                {"error,picture=2", "not run"}});
    CHECK(place.logged("fail") == 1);
    place.clear_log();
    const Finished going = place.run({"run", "room.yaml", "--keep-going"}, 1);
    CHECK(place.logged("fail") == 2);
    CHECK(place.read("out/picture=2/sum.txt") == "3.000000\n");
    CHECK(contains(going.out, "at bad@error\n4 combinations: 4 failed\n"));
}

TEST_CASE("a missing input stops only its own combinations by --keep-going, and is said first")
{
    Workplace place;
    place.write("one.txt", "1");
    place.write("room.yaml", matrix("[one.txt, two.txt]", R"(
  base: {type: test.source, file: "${n}", log: log}
  text: {type: test.sink, input: base, path: sum.txt, log: log}
)"));
    place.run({"run", "room.yaml"}, 3);
    CHECK(place.log().empty());
    const Finished going = place.run({"run", "room.yaml", "--keep-going", "--json-log"}, 3);
    CHECK(going.err.starts_with("room.yaml:6:35: error: stage 'base' (test.source): option 'file': no such file '"));
    CHECK(place.logged("sink") == 1);
    CHECK(fs::exists(place.file("out/one/sum.txt")));
    CHECK(place.read_json("out/sweep.json").at("exit_code").as_int() == 3);
    CHECK(events(going.out, "problems").size() == 1);
    // Another problem stops all of them.
    place.run({"run", "room.yaml", "--keep-going", "--set", "text.paht=x"}, 2);
    CHECK(place.logged("sink") == 1);
}

TEST_CASE("an interrupted sweep goes on where it was")
{
    RoomPlace place(matrix("[5, 6, 7]", "  slow: {type: test.slow, steps: \"${n}\", step_ms: 1, log: log}\n"
                                        "  text: {type: test.sink, input: slow, path: n.txt}\n"));
    // So slow that it is not done before a busy machine hears of the signal.
    const auto run = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=500"});
    wait_until(
        [&]
        {
            const std::string out = run->out();
            const std::size_t second = out.find("\"begin\",\"stage\":\"slow@n=6\"");
            return second != std::string::npos && out.find("\"progress\"", second) != std::string::npos;
        });
    run->signal(SIGINT);
    CHECK(run->wait().code == 75);
    CHECK(cells(place) == Cells{{"n=5", "done"}, {"n=6", "interrupted"}, {"n=7", "not run"}});
    CHECK(contains(place.make().out, "3 combinations: 3 done"));
    const Words log = place.log();
    REQUIRE(log.size() == 5);
    CHECK(log[3] != "slow from 0");
    CHECK(log[4] == "slow from 0");
    CHECK(place.read("out/n=6/n.txt") == "6.000000\n");
}

TEST_CASE("plan, check, --until and --set know the matrix")
{
    RoomPlace place(sweep);
    CHECK(contains(place.run({"check", "room.yaml"}).err, "13 stages of 4 combinations, no problems"));
    CHECK(contains(place.run({"plan", "room.yaml"}).out, "paint@scan=1,wild "));
    place.make({"--until", "scan_of"});
    CHECK(place.log().size() == 2);
    place.make({"--set", "scan=2", "--set", "picture=wild"});
    CHECK(cells(place) == Cells{{"scan=2,wild", "done"}});
    CHECK(place.logged("add begins") == 1);
    CHECK(contains(place.run({"run", "room.yaml", "--set", "scan=3"}).err, "the axis 'scan' of the matrix has no value '3'"));
    // A sweep of one value still names what it made, and keeps what gc must not take.
    place.make();
    place.make({"--set", "scan=1"});
    REQUIRE(place.run({"store", "gc", "--keep-days", "0"}).code == 0);
    place.clear_log();
    place.make();
    CHECK(place.log().empty());
}

TEST_CASE("no two stages write one file, whichever way its folder came about, and a stage's own sweep.json is kept")
{
    Workplace place;
    const auto stages = [](const std::string& path)
    {
        return matrix("{small: 1, large: 2}", "  one:   {type: test.source, value: \"${n}\"}\n"
                                              "  other: {type: test.source, value: 7}\n"
                                              "  text:  {type: test.sink, input: one, path: f.txt}\n"
                                              "  plain: {type: test.sink, input: other, path: " +
                                                  path + "}\n");
    };
    place.write("room.yaml", stages("small/f.txt"));
    CHECK(contains(place.run({"run", "room.yaml", "--keep-going"}, 1).err,
                   "would both write small/f.txt below --out: give one of them another path"));
    CHECK(place.read("out/large/f.txt") == "2.000000\n");
    // Equal files are no conflict.
    place.make({"--set", "other.value=1", "--out", "agreed"});
    CHECK(place.read("agreed/small/f.txt") == "1.000000\n");

    place.write("room.yaml", stages("sweep.json"));
    const Finished own = place.make({"--out", "own"});
    CHECK(place.read("own/sweep.json") == "7.000000\n");
    CHECK(contains(own.err, "no summary of the combinations: the stage plain writes sweep.json itself"));
    CHECK_FALSE(fs::exists(place.file("own/sweep.html")));
}
