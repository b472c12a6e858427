#include "program.h"

#include <algorithm>

namespace
{

const char* const two = R"(version: 1
vars: {start: 4}
stages:
  source: {type: test.source, value: "${start}", log: log}
  add:    {type: test.add, input: {left: source}, plus: 1}
  text:   {type: test.sink, input: add, path: x.txt}
)";

}  // namespace

TEST_CASE("a run leaves a report, and does not write it again where nothing changed")
{
    Workplace place;
    place.write("room.yaml", two);
    const Finished first = place.run({"run", "room.yaml"});
    REQUIRE(first.code == 0);
    CHECK(contains(first.out, "\nout/report.html\n"));
    const std::string page = place.read("out/report.html");
    for (const char* part :
         {"room.yaml: <span class=\"good\">done", "3 of 3 stages ran", "test.add", "href=\"./x.txt\"", "</html>"})
        CHECK(contains(page, part));
    CHECK(contains(page, "There are no pictures: no plugin"));
    CHECK(page.find("http") == std::string::npos);

    const auto written = fs::last_write_time(place.file("out/report.html"));
    const Finished again = place.run({"run", "room.yaml"});
    CHECK(contains(again.out, "out/report.html  (unchanged)"));
    CHECK(fs::last_write_time(place.file("out/report.html")) == written);

    REQUIRE(place.run({"run", "room.yaml", "--set", "add.plus=2"}).code == 0);
    CHECK(contains(place.read("out/report.html"), "2 of 3 stages ran, 1 were stored already"));
    // Back to what is stored: nothing runs, but the report is of other results.
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(contains(place.read("out/report.html"), "0 of 3 stages ran, 3 were stored already"));

    // Until a stage: what is after it has no result that could tell of it.
    for (const char* plus : {"1", "2", "1"})
    {
        REQUIRE(place.run({"run", "room.yaml", "--until", "add", "--set", std::string("add.plus=") + plus}).code == 0);
        CHECK(contains(place.read("out/report.html"), std::string("<dt>plus</dt><dd><code>") + plus));
    }

    fs::remove_all(place.file("out"));
    REQUIRE(place.run({"run", "room.yaml", "--no-report"}).code == 0);
    CHECK_FALSE(fs::exists(place.file("out/report.html")));
}

TEST_CASE("a failed run's report names what went wrong and what did not run")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  source: {type: test.source}
  bad:    {type: test.fail, input: source}
  text:   {type: test.sink, input: bad, path: x.txt}
)");
    const Finished failed = place.run({"run", "room.yaml"});
    REQUIRE(failed.code == 1);
    const std::string page = place.read("out/report.html");
    CHECK(contains(page, "class=\"bad\">failed"));
    CHECK(contains(page, "<div class=\"error\">room.yaml:4:3: error: stage bad (test.fail): mesh.ply:7: three vertices"));
    CHECK(contains(page, "class=\"stage not-run\""));
}

TEST_CASE("a stage's own report.html stays, and a report that cannot be written fails no run")
{
    Workplace place;
    std::string own = two;
    own.replace(own.find("x.txt"), 5, "report.html");
    place.write("own.yaml", own);
    const Finished finished = place.run({"run", "own.yaml"});
    CHECK(finished.code == 0);
    CHECK(contains(finished.err, "the stage text writes report.html itself"));
    CHECK(place.read("out/report.html").find("<html") == std::string::npos);

    place.write("room.yaml", two);
    fs::create_directories(place.file("other/report.html"));
    const Finished blocked = place.run({"run", "room.yaml", "--out", "other"});
    CHECK(blocked.code == 0);
    CHECK(contains(blocked.err, "report.html"));
    CHECK(contains(place.read("other/x.txt"), "5.0"));

    place.write("mine/report.html", "<h1>My own</h1>");
    const Finished beside = place.run({"run", "room.yaml", "--out", "mine"});
    CHECK(beside.code == 0);
    CHECK(contains(beside.err, "mine/report.html: not a report that fresco wrote"));
    CHECK(place.read("mine/report.html") == "<h1>My own</h1>");
}

TEST_CASE("a report whose pictures could not be made is made again by the next run")
{
    Workplace place({"good", "pictures"});
    std::string crashing = two;
    crashing.replace(crashing.find("x.txt"), 5, "x.png");
    place.write("room.yaml", crashing);
    // The picture of 13 ends the process that opens it.
    for (int run = 0; run < 2; ++run)
    {
        const Finished without = place.run({"run", "room.yaml", "--set", "add.plus=9"});
        CHECK(without.code == 0);
        CHECK(contains(without.err, "out/report.html is without pictures: the process that makes them ended by"));
        CHECK_FALSE(contains(without.out, "out/report.html  (unchanged)"));
        CHECK(contains(place.read("out/report.html"), "There are no pictures: the process"));
    }
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK_FALSE(contains(place.read("out/report.html"), "There are no pictures"));
    CHECK(contains(place.run({"run", "room.yaml"}).out, "out/report.html  (unchanged)"));
}

TEST_CASE("metrics of a stage are drawn over its progress, through an interruption too")
{
    Workplace place;
    place.write("room.yaml", R"(version: 1
stages:
  slow: {type: test.slow, steps: 60, step_ms: 20}
)");
    const auto running = place.start({"run", "room.yaml", "--json-log"});
    const fs::path out = place.root() / "out1";
    Workplace::wait_until(
        [&]
        {
            const auto all = events(fs::exists(out) ? fresco::read_text_file(out) : "");
            return std::ranges::count_if(all, [](const auto& event) { return event.at("event").as_string() == "progress"; }) > 2;
        });
    running->signal(SIGTERM);
    CHECK(running->wait().code == 75);
    const std::string interrupted = place.read("out/report.html");
    CHECK(contains(interrupted, "room.yaml: <span class=\"bad\">interrupted"));
    CHECK(contains(interrupted, "class=\"stage interrupted\""));
    CHECK(contains(interrupted, "pictures come with the report of the next"));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(contains(place.read("out/report.html"), "room.yaml: <span class=\"good\">done"));
    CHECK(contains(place.read("out/report.html"), "loss over steps: first 1, last 0.01667, least 0.01667"));
}

TEST_CASE("each combination of a matrix has its own report")
{
    Workplace place;
    std::string matrix = two;
    matrix.replace(matrix.find("vars: {start: 4}"), 16, "vars: {start: }\nmatrix: {start: [4, 7]}");
    place.write("room.yaml", matrix);
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    for (const char* name : {"start=4", "start=7"})
    {
        const std::string page = place.read("out/" + std::string(name) + "/report.html");
        CHECK(contains(page, "room.yaml, " + std::string(name) + ": <span"));
        CHECK(contains(page, "3 of 3 stages ran"));
        CHECK(contains(page, "href=\"./x.txt\""));
    }
    CHECK_FALSE(fs::exists(place.file("out/report.html")));

    place.write("fails.yaml", R"(version: 1
vars: {start: }
matrix: {start: [4, 7]}
stages:
  source: {type: test.source, value: "${start}"}
  bad:    {type: test.fail, input: source}
)");
    REQUIRE(place.run({"run", "fails.yaml", "--out", "fails"}).code == 1);
    CHECK(contains(place.read("fails/start=4/report.html"), "fails.yaml, start=4: <span class=\"bad\">failed"));
    CHECK(contains(place.read("fails/start=7/report.html"), "fails.yaml, start=7: <span class=\"bad\">not finished"));
}
