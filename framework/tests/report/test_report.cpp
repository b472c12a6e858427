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

/// run.json, which the page holds too.
fresco::Value data_of(const Workplace& place, const std::string& folder = "out")
{
    const auto data = fresco::parse_json(place.read(folder + "/run.json"), "run.json");
    CHECK(page_json(place.read(folder + "/report.html"), "data") == data);
    return data;
}

/// "source ran, add stored, …"
std::string states_of(const fresco::Value& data)
{
    std::string text;
    for (const auto& stage : data.at("stages").as_list())
        text += (text.empty() ? "" : ", ") + stage.at("name").as_string() + " " + stage.at("state").as_string();
    return text;
}

std::string notes_of(const Workplace& place)
{
    std::string text;
    const auto media = page_json(place.read("out/report.html"), "media");
    for (const auto& entry : media.as_list())
        if (const auto* notes = entry.find("notes"))
            for (const auto& note : notes->as_list())
                text += note.as_string() + "\n";
    return text;
}

}  // namespace

TEST_CASE("a run leaves a report, and does not write it again where nothing changed")
{
    Workplace place;
    place.write("room.yaml", two);
    const Finished first = place.run({"run", "room.yaml"});
    REQUIRE(first.code == 0);
    CHECK(contains(first.out, "\nout/report.html\n"));
    const auto data = data_of(place);
    CHECK(data.at("format").as_string() == "fresco-run");
    CHECK(data.at("outcome").as_string() == "done");
    CHECK(data.at("command").as_list().at(2) == fresco::Value("room.yaml"));
    CHECK(data.at("directory") == fresco::Value(place.work().string()));
    const auto& pipeline = data.at("pipeline");
    CHECK(pipeline.at("name").as_string() == "room.yaml");
    CHECK(pipeline.at("texts") ==
          fresco::Value(fresco::Value::List{fresco::Value::Map{{"file", place.file("room.yaml").string()}, {"text", two}}}));
    CHECK(states_of(data) == "source ran, add ran, text ran");
    const auto& add = data.at("stages").as_list().at(1);
    CHECK(add.at("type").as_string() == "test.add");
    CHECK(add.at("options").at("plus") == fresco::Value(1.0));
    CHECK(add.at("inputs") ==
          fresco::parse_json(R"([{"port": "left", "artifact": "table", "stage": "source", "output": "table"}])"));
    CHECK(add.at("versions").find("fresco") != nullptr);
    CHECK(data.at("stages").as_list().at(0).at("messages") == fresco::parse_json(R"([{"message": "made 4.000000"}])"));
    CHECK(data.at("files") == fresco::parse_json(R"([{"stage": "text", "name": "x.txt", "bytes": 9}])"));
    const std::string page = place.read("out/report.html");
    CHECK(contains(page, "</html>"));
    CHECK(contains(page, "<noscript>"));
    CHECK(contains(notes_of(place), "There are no pictures: no plugin"));

    const auto written = fs::last_write_time(place.file("out/report.html"));
    const Finished again = place.run({"run", "room.yaml"});
    CHECK(contains(again.out, "out/report.html  (unchanged)"));
    CHECK(fs::last_write_time(place.file("out/report.html")) == written);

    REQUIRE(place.run({"run", "room.yaml", "--set", "add.plus=2"}).code == 0);
    CHECK(states_of(data_of(place)) == "source stored, add ran, text ran");
    // Back to what is stored: nothing runs, but the report is of other results.
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(states_of(data_of(place)) == "source stored, add stored, text stored");
    CHECK(data_of(place).at("stages").as_list().at(0).at("seconds").as_double() > 0);  // When it was made.

    // Until a stage: what is after it has no result that could tell of it.
    for (const char* plus : {"1", "2", "1"})
    {
        REQUIRE(place.run({"run", "room.yaml", "--until", "add", "--set", std::string("add.plus=") + plus}).code == 0);
        const auto data_until = data_of(place);
        CHECK(data_until.at("stages").as_list().at(1).at("options").at("plus").as_double() == std::stod(plus));
        CHECK(states_of(data_until).ends_with("text not selected"));
    }

    fs::remove_all(place.file("out"));
    REQUIRE(place.run({"run", "room.yaml", "--no-report"}).code == 0);
    CHECK_FALSE(fs::exists(place.file("out/report.html")));
    CHECK_FALSE(fs::exists(place.file("out/run.json")));
}

TEST_CASE("nothing in a run's names and texts can leave the page's data")
{
    Workplace place;
    const std::string hostile = "</script><script>alert(1)</script><!--";
    place.write("room.yaml", "version: 1  # " + hostile +
                                 "\nstages:\n  source: {type: test.source}\n"
                                 "  text: {type: test.sink, input: source, path: \"<img src=x onerror=alert(1)>.txt\"}\n");
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const auto data = data_of(place);
    CHECK(contains(data.at("pipeline").at("texts").as_list().at(0).at("text").as_string(), hostile));
    const std::string page = place.read("out/report.html");
    CHECK_FALSE(page.find("alert(1)</script>") != std::string::npos);
    CHECK_FALSE(page.find("<img src=x") != std::string::npos);
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
    const auto data = data_of(place);
    CHECK(data.at("outcome").as_string() == "failed");
    CHECK(data.at("exit_code").as_int() == 1);
    CHECK(states_of(data) == "source ran, bad failed, text not run");
    const auto& problem = data.at("problems").as_list().at(0);
    CHECK(problem.at("stage").as_string() == "bad");
    CHECK(contains(problem.at("text").as_string(), "room.yaml:4:3: error: stage bad (test.fail): mesh.ply:7: three vertices"));
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
    CHECK(contains(beside.err, "mine/report.html: was not written by fresco and stays"));
    CHECK(place.read("mine/report.html") == "<h1>My own</h1>");
    place.write("data/run.json", "{}");
    CHECK(contains(place.run({"run", "room.yaml", "--out", "data"}).err, "data/run.json: was not written by fresco and stays"));
    CHECK_FALSE(fs::exists(place.file("data/report.html")));
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
        CHECK(contains(without.err, "when it showed text.files"));
        CHECK_FALSE(contains(without.out, "out/report.html  (unchanged)"));
        CHECK(contains(notes_of(place), "There are no pictures: the process"));
    }
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    CHECK(notes_of(place).empty());
    const auto media = page_json(place.read("out/report.html"), "media");
    REQUIRE(media.as_list().size() == 1);
    CHECK(media.as_list()[0].at("folder").as_string().empty());
    CHECK(media.as_list()[0].at("pictures").as_list().at(0).at("name").as_string() == "x.png");
    REQUIRE(place.run({"run", "room.yaml", "--set", "add.plus=10"}).code == 0);
    CHECK(contains(notes_of(place), "x.png: is cut"));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
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
    const auto interrupted = data_of(place);
    CHECK(interrupted.at("outcome").as_string() == "interrupted");
    CHECK(states_of(interrupted) == "slow interrupted");
    CHECK(contains(notes_of(place), "pictures come with the report of the next"));
    REQUIRE(place.run({"run", "room.yaml"}).code == 0);
    const auto data = data_of(place);
    CHECK(data.at("outcome").as_string() == "done");
    const auto& curves = data.at("stages").as_list().at(0).at("curves");
    CHECK(curves.at("unit").as_string() == "steps");
    const auto& losses = curves.at("metrics").at("loss").as_list();
    REQUIRE(losses.size() == curves.at("done").as_list().size());
    CHECK(losses.front() == fresco::Value(1.0));
    CHECK(losses.back().as_double() == Approx(1.0 / 60));
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
        const auto data = data_of(place, "out/" + std::string(name));
        CHECK(data.at("pipeline").at("combination").at("start").as_string() == name);
        CHECK(data.at("stages").as_list().size() == 3);
        CHECK(data.at("files").as_list().at(0).at("name").as_string() == "x.txt");
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
    CHECK(data_of(place, "fails/start=4").at("outcome").as_string() == "failed");
    CHECK(data_of(place, "fails/start=7").at("outcome").as_string() == "not finished");
}
