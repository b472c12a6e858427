#include "program.h"

#include "report/page.h"
#include "report/report.h"
#include <fresco/file_access.h>

#include <fcntl.h>
#include <regex>
#include <sys/socket.h>

using namespace fresco::host;

namespace
{

/// run.json, which the page holds too.
fresco::Value data_of(const Workplace& place, const std::string& folder = "out")
{
    const auto data = place.read_json(folder + "/run.json");
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

std::size_t occurrences(const std::string& text, const std::string& part)
{
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

/// Whether a whole line has this event, of a file that is being written.
bool contains_event(const std::string& text, const std::string& name)
{
    return text.find("{\"event\":\"" + name + "\"") != std::string::npos;
}

const char* const sweep = R"(version: 1
vars: {n: }
matrix: {n: [110, 120, 130]}
stages:
  one:  {type: test.source, value: "${n}"}
  view: {type: test.sink, input: one, path: view.png}
)";

/// Message about a page that this shell script makes.
std::string said_of(const std::string& script, std::chrono::milliseconds limit)
{
    int sockets[2];
    REQUIRE(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, sockets) == 0);
    const fresco::FileDescriptor its_channel(sockets[1]);
    fresco::Process process = fresco::start_process(
        {.file = "/bin/sh", .arguments = {"sh", "-c", script}, .channel = its_channel.get(), .own_session = true});
    return wait_for_page({process.pid, fresco::FileDescriptor(sockets[0]), std::move(process.output)}, limit);
}

}  // namespace

TEST_CASE("a run leaves a report, and does not write it again where nothing changed")
{
    RoomPlace place;
    CHECK(contains(place.make().out, "\nout/report.html\n"));
    const auto data = data_of(place);
    CHECK(data.at("format").as_string() == "fresco-run");
    CHECK(data.at("outcome").as_string() == "done");
    CHECK(data.at("command").as_list().at(2) == fresco::Value("room.yaml"));
    CHECK(data.at("pipeline").at("texts").as_list().at(0).at("text") == fresco::Value(chain));
    CHECK(states_of(data) == "source ran, add ran, text ran");
    const auto& add = data.at("stages").as_list().at(1);
    CHECK(add.at("options").at("plus") == fresco::Value(1.0));
    CHECK(add.at("inputs") ==
          fresco::parse_json(R"([{"port": "left", "artifact": "table", "stage": "source", "output": "table"}])"));
    CHECK(data.at("stages").as_list().at(0).at("messages") == fresco::parse_json(R"([{"message": "made 4.000000"}])"));
    CHECK(data.at("files") == fresco::parse_json(R"([{"stage": "text", "name": "x.txt", "bytes": 9}])"));
    CHECK(contains(notes_of(place), "There are no pictures: no plugin"));

    const auto written = fs::last_write_time(place.file("out/report.html"));
    CHECK(contains(place.make().out, "out/report.html  (unchanged)"));
    CHECK(fs::last_write_time(place.file("out/report.html")) == written);

    place.make({"--set", "add.plus=2"});
    CHECK(states_of(data_of(place)) == "source stored, add ran, text ran");
    // Back to what is stored: nothing runs, but the report is of other results.
    place.make();
    CHECK(states_of(data_of(place)) == "source stored, add stored, text stored");
    CHECK(data_of(place).at("stages").as_list().at(0).at("seconds").as_double() > 0);  // When it was made.

    // Until a stage: what is after it has no result that could tell of it.
    for (const char* plus : {"1", "2", "1"})
    {
        place.make({"--until", "add", "--set", std::string("add.plus=") + plus});
        CHECK(data_of(place).at("stages").as_list().at(1).at("options").at("plus").as_double() == std::stod(plus));
        CHECK(states_of(data_of(place)).ends_with("text not selected"));
    }

    fs::remove_all(place.file("out"));
    place.make({"--no-report"});
    CHECK(place.read("out/report.html") + place.read("out/run.json") + place.read("out/progress.jsonl") == "");
}

TEST_CASE("the events of a run lie beside its results while it goes on")
{
    RoomPlace place("\n  slow: {type: test.slow, steps: 1000, step_ms: 100, log: log}\n");
    const auto is_locked = [&]
    {
        const fresco::FileDescriptor file(open(place.file("out/progress.jsonl").c_str(), O_RDONLY | O_CLOEXEC));
        struct flock lock = {};
        lock.l_type = F_RDLCK;
        REQUIRE(fcntl(file.get(), F_OFD_GETLK, &lock) == 0);
        return lock.l_type != F_UNLCK;
    };
    {
        const auto run = place.start({"run", "room.yaml"});
        wait_until([&] { return contains_event(place.read("out/progress.jsonl"), "progress"); });
        CHECK(is_locked());
    }
    CHECK_FALSE(is_locked());
    const auto begun = events(place.read("out/progress.jsonl"));
    CHECK(begun.front().at("event").as_string() == "stages");
    CHECK(begun.front().at("stages").as_list().at(0).at("stage").as_string() == "slow");
    CHECK(events(place.read("out/progress.jsonl"), "summary").empty());
    // The file of a run that was killed is fresco's to replace.
    place.make({"--set", "slow.steps=3"});
    const auto all = events(place.read("out/progress.jsonl"));
    CHECK(all.back().at("event").as_string() == "summary");
    CHECK(all.back().at("exit_code") == fresco::Value(0));
    CHECK(events(place.read("out/progress.jsonl"), "end").size() == 1);
    const Finished printed = place.make({"--set", "slow.steps=4", "--json-log"});
    const auto untimed = [](const std::string& text)
    { return std::regex_replace(text, std::regex(",\"time_s\":[0-9.e-]+"), ""); };
    CHECK(untimed(printed.out) == untimed(place.read("out/progress.jsonl")));
    double last_s = 0;
    for (const auto& event : events(place.read("out/progress.jsonl")))
        if (const auto* time_s = event.find("time_s"))
            CHECK(std::exchange(last_s, time_s->as_double()) <= time_s->as_double());
    CHECK(last_s >= 0.4);  // Four steps of 0.1 s.
    // The user's own stays.
    place.write("out/progress.jsonl", "mine");
    CHECK(contains(place.run({"run", "room.yaml", "--set", "slow.steps=3"}, 1).err,
                   "progress.jsonl: changed since fresco wrote it"));
    CHECK(place.read("out/progress.jsonl") == "mine");
    place.make({"--set", "slow.steps=3", "--replace"});
    CHECK(contains(place.read("out/progress.jsonl"), "summary"));
}

TEST_CASE("nothing in a run's names and texts can leave the page's data")
{
    Workplace place;
    const std::string hostile = "</script><script>alert(1)</script><!--";
    place.write("room.yaml", "version: 1  # " + hostile +
                                 "\nstages:\n  source: {type: test.source}\n"
                                 "  text: {type: test.sink, input: source, path: \"<img src=x onerror=alert(1)>.txt\"}\n");
    place.make();
    CHECK(contains(data_of(place).at("pipeline").at("texts").as_list().at(0).at("text").as_string(), hostile));
    for (const char* text : {"alert(1)</script>", "<img src=x"})
        CHECK(occurrences(place.read("out/report.html"), text) == 0);
}

TEST_CASE("a stage's own report.html stays, and so does what lies in a report's place")
{
    Workplace place;
    std::string own = chain;
    own.replace(own.find("x.txt"), 5, "report.html");
    place.write("own.yaml", own);
    CHECK(contains(place.run({"run", "own.yaml"}, 0).err, "the stage text writes report.html itself"));
    place.run({"run", "own.yaml", "--set", "source.value=7"}, 0);
    CHECK(place.read("out/report.html").find("<html") == std::string::npos);

    place.write("room.yaml", chain);
    fs::create_directories(place.file("other/report.html"));
    CHECK(contains(place.run({"run", "room.yaml", "--out", "other"}, 1).err, "report.html: is a folder"));
    CHECK(contains(place.run({"run", "room.yaml", "--out", "other", "--replace"}, 1).err, "move it away"));

    for (const std::string mine : {"report.html", "run.json"})
    {
        place.write(mine + "/" + mine, "mine");
        CHECK(contains(place.run({"run", "room.yaml", "--out", mine}, 1).err, mine + ": is not in fresco's record"));
        CHECK(place.read(mine + "/" + mine) == "mine");
    }
    // The stage's own report is no report that any run may replace.
    CHECK(contains(place.run({"run", "room.yaml"}, 1).err, "report.html: was written by another pipeline"));
}

TEST_CASE("a report whose pictures could not be made is made again by the next run")
{
    Workplace place({"good", "pictures"});
    std::string crashing = chain;
    crashing.replace(crashing.find("x.txt"), 5, "x.png");
    place.write("room.yaml", crashing);
    // The picture of 13 ends the process that opens it.
    for (int run = 0; run < 2; ++run)
    {
        const Finished without = place.make({"--set", "add.plus=9"});
        CHECK(contains(without.err, "out/report.html is without pictures: the process that makes them ended by"));
        CHECK(contains(without.err, "when it showed text.files"));
        CHECK_FALSE(contains(without.out, "out/report.html  (unchanged)"));
        CHECK(contains(notes_of(place), "There are no pictures: the process"));
    }
    place.make();
    CHECK(notes_of(place).empty());
    const auto media = page_json(place.read("out/report.html"), "media");
    REQUIRE(media.as_list().size() == 1);
    CHECK(media.as_list()[0].at("pictures").as_list().at(0).at("name").as_string() == "x.png");
    place.make({"--set", "add.plus=10"});
    CHECK(contains(notes_of(place), "x.png: is cut"));
    place.make();
    CHECK(contains(place.make().out, "out/report.html  (unchanged)"));
}

TEST_CASE("metrics of a stage are drawn over its progress, through an interruption too")
{
    RoomPlace place(R"(
  slow: {type: test.slow, steps: 60, step_ms: 20}
)");
    const auto running = place.start({"run", "room.yaml", "--json-log", "--set", "slow.step_ms=500"});
    wait_until([&] { return running->says("\"progress\""); });
    running->signal(SIGTERM);
    CHECK(running->wait().code == 75);
    const auto interrupted = data_of(place);
    CHECK(interrupted.at("outcome").as_string() == "interrupted");
    CHECK(states_of(interrupted) == "slow interrupted");
    CHECK(contains(notes_of(place), "pictures come with the report of the next"));
    place.make();
    const auto data = data_of(place);
    CHECK(data.at("outcome").as_string() == "done");
    const auto& curves = data.at("stages").as_list().at(0).at("curves");
    CHECK(curves.at("unit").as_string() == "steps");
    const auto& losses = curves.at("metrics").at("loss").as_list();
    REQUIRE(losses.size() == curves.at("done").as_list().size());
    CHECK(losses.front() == fresco::Value(1.0));
    CHECK(losses.back().as_double() == Approx(1.0 / 60));
}

TEST_CASE("each combination of a matrix has its own report, which names what went wrong and what did not run")
{
    Workplace place;
    std::string matrix = chain;
    matrix.replace(matrix.find("vars: {start: 4}"), 16, "vars: {start: }\nmatrix: {start: [4, 7]}");
    place.write("room.yaml", matrix);
    place.make();
    for (const char* name : {"start=4", "start=7"})
    {
        const auto data = data_of(place, "out/" + std::string(name));
        CHECK(data.at("pipeline").at("combination").at("start").as_string() == name);
        CHECK(data.at("files").as_list().at(0).at("name").as_string() == "x.txt");
    }
    CHECK_FALSE(fs::exists(place.file("out/report.html")));

    place.write("fails.yaml", R"(version: 1
vars: {start: }
matrix: {start: [4, 7]}
stages:
  source: {type: test.source, value: "${start}"}
  bad:    {type: test.fail, input: source}
  text:   {type: test.sink, input: bad, path: x.txt}
)");
    place.run({"run", "fails.yaml", "--out", "fails"}, 1);
    const auto failed = data_of(place, "fails/start=4");
    CHECK(failed.at("outcome").as_string() == "failed");
    CHECK(failed.at("exit_code").as_int() == 1);
    CHECK(states_of(failed) == "source@start=4 stored, bad@start=4 failed, text@start=4 not run");
    CHECK(contains(failed.at("problems").as_list().at(0).at("text").as_string(), "fails.yaml:6:3: error: stage bad@start=4 "));
    CHECK(data_of(place, "fails/start=7").at("outcome").as_string() == "not finished");
}

TEST_CASE("pictures of a combination: of the last stage that made some only for it, evenly spaced")
{
    Pipeline pipeline;
    for (const auto& [own_name, place] : {std::pair{"views", "a"}, {"shared", ""}, {"text", "a"}, {"extra", "a"}})
    {
        PipelineStage& stage = pipeline.stages.emplace_back();
        stage.name = stage.own_name = own_name;
        stage.place = place;
    }
    const Combination combination{"a", {"a"}, {0, 1, 2, 3}};
    RunSummary summary;
    CombinationOutcome outcome;
    outcome.combination = &combination;
    const auto add = [&](const char* stage, const std::string& name)
    {
        outcome.files.push_back(summary.files.size());
        summary.files.push_back({stage, "/out/" + name, true});
    };
    using Numbers = std::vector<std::size_t>;
    const auto chosen = [&](const std::string& stage, std::size_t most) {
        return pictures_of(pipeline, summary, outcome, {".png", ".jpg"}, stage, most);
    };
    CHECK(chosen("", 3).empty());
    for (int i = 0; i < 10; ++i)
        add("views", std::to_string(i) + ".png");
    add("shared", "last.jpg");
    add("text", "a.txt");
    CHECK(chosen("", 1) == Numbers{5});
    CHECK(chosen("", 3) == Numbers{1, 5, 8});
    CHECK(chosen("", 20).size() == 10);
    CHECK(chosen("shared", 3) == Numbers{10});
    CHECK(chosen("text", 3).empty());
    add("extra", "b.jpg");
    CHECK(chosen("", 3) == Numbers{12});
}

TEST_CASE("a sweep ends with a page of small pictures, which stays where nothing is new")
{
    RoomPlace place(sweep, {"good", "pictures"});
    CHECK(contains(place.make().out, "out/sweep.html"));
    const std::string html = place.read("out/sweep.html");
    for (const char* text : {"480px of 110", "480px of 120", "480px of 130"})
        CHECK(occurrences(html, text) == 1);
    const auto data = page_json(html, "data");
    const auto& second = data.at("combinations").as_list().at(1);
    CHECK(second.at("pictures") == fresco::Value(fresco::Value::List{"n=120/view.png"}));
    CHECK(second.at("report").as_string() == "n=120/report.html");
    const auto written = place.read_json("out/sweep.json");
    CHECK(written.at("stages") == data.at("stages"));
    CHECK(written.at("stages").as_list().at(0).at("figures").find("threads") != nullptr);
    CHECK(page_json(html, "media").as_list().at(1).at("folder").as_string() == "n=120");
    place.make();
    CHECK(place.read("out/sweep.html") == html);
    place.make({"--set", "n=[110, 140]"});
    CHECK(occurrences(place.read("out/sweep.html"), "data:,480px of 140") == 1);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
    CHECK(contains(place.run({"run", "room.yaml", "--thumbnails", "veiw"}).err,
                   "--thumbnails veiw: error: unknown stage 'veiw' (did you mean 'view'?)"));
    place.make({"--thumbnails", "one"});
    CHECK(page_json(place.read("out/sweep.html"), "media").as_list().empty());
}

TEST_CASE("while a page is made the store is in use")
{
    RoomPlace place(sweep, {"good", "pictures"});
    const auto run = place.start({"run", "room.yaml", "--no-report", "--set", "n=[15, 110]"});
    wait_until([&] { return fs::exists(place.file("open")); });
    const Store store(place.file(".fresco"));
    CHECK_FALSE(store_lock(store).try_exclusive());
    fs::remove(place.file("open"));
    CHECK(run->wait().code == 0);
    CHECK(occurrences(place.read("out/sweep.html"), "data:,480px of 15") == 1);
    CHECK(store_lock(store).try_exclusive());
}

TEST_CASE("a preview that hangs is ended, and its artifact is named")
{
    using namespace std::chrono_literals;
    const std::string process = "the process that makes them ";
    CHECK(said_of("trap '' TERM; echo scan.frames >&3; sleep 100", 2s) ==
          process + "did not return within 2.0 s when it showed scan.frames");
    CHECK(said_of("echo scan.frames >&3; kill -SEGV $$", 100s) ==
          process + "ended by Segmentation fault (signal 11) when it showed scan.frames");
    CHECK(said_of("exit 3", 100s) == process + "ended with code 3");
    CHECK(said_of("echo scan.frames >&3; echo first; echo why; exit 1", 100s) == "why");
    // The limit is that of one artifact; and what such a process leaves running is not waited for.
    CHECK(said_of("for i in 1 2 3 4 5 6 7 8; do echo $i >&3; sleep 0.5; done", 3s).empty());
    CHECK(said_of("sleep 100 & echo done", 100s).empty());
}
