#include "program.h"

#include "base/common.h"
#include "store/store.h"
#include "worker/stage_run.h"
#include "worker/worker_context.h"

#include <fresco/files_io.h>

using namespace fresco::host;
using fresco::Value;

namespace
{

fs::path object_with(const Workplace& place, const std::string& output)
{
    for (const auto& object : place.objects())
        if (fs::exists(object / output))
            return object;
    return "nothing with " + output;
}

Value manifest_in(const fs::path& object)
{
    return fresco::parse_json(fresco::read_text_file(object / "manifest.json"));
}

/// Origin that a stage at the end of a diamond is told.
std::string told(Workplace& place)
{
    place.write("scan/a", "12");
    place.write("extra", "123");
    place.write_stages(R"(
  source: {type: test.source, value: 3, folder: scan, file: extra, log: log}
  other:  {type: test.source, value: 4, log: log}
  scale:  {type: test.scale, input: source, log: log}
  add:    {type: test.add, input: {left: scale, right: source}, log: log}
  sum:    {type: test.add, input: {left: add, right: other}, log: log}
  told:   {type: test.sink, input: sum, origin: true, path: origin.json, log: log}
)");
    place.make({"--cores", "1"});
    return place.read("out/origin.json");
}

}  // namespace

TEST_CASE("Every failure has an error message and the right exit code, and publishes nothing")
{
    Workplace place;
    for (const auto& [how, code, words] : std::vector<std::tuple<std::string, int, std::string>>{
             {"error", 1, "three vertices expected"},
             {"missing", 3, "weights.safetensors: no such file"},
             {"exception", 1, "unexpected error, please report it to the plugin's author: index 7 of 3"},
             {"memory", 1, "not enough memory"},
             {"full", 1, "free some space"},
             {"nothing", 1, "output"},
             {"link", 1, "output/link"}})
    {
        INFO(how);
        place.write_stages("\n  bad: {type: test.fail, how: " + how + "}\n");
        const Finished finished = place.run({"run", "room.yaml"});
        CHECK(finished.code == code);
        CHECK(contains(finished.err, words));
        CHECK(contains(finished.err, "room.yaml:3:3: error: stage bad (test.fail)"));
        CHECK(place.objects().empty());
    }
}

TEST_CASE("An output that is left out leaves an optional input empty, and stops a stage that needs it")
{
    RoomPlace place(R"(
  maybe: {type: test.maybe, log: log}
  add:   {type: test.add, input: {left: maybe.always, right: maybe.table}}
  text:  {type: test.sink, input: add, path: sum.txt}
)");
    place.make();
    CHECK(place.read("out/sum.txt") == "8.000000\n");
    const Words without{"--set", "maybe.made=false"};
    place.make(without);
    CHECK(place.read("out/sum.txt") == "1.000000\n");
    // It is stored as it is.
    place.clear_log();
    place.make(without);
    CHECK(place.log().empty());

    place.write_stages("\n  maybe: {type: test.maybe, made: false}\n  text: {type: test.sink, input: maybe.table}\n");
    CHECK(contains(place.run({"run", "room.yaml"}, 3).err,
                   "room.yaml:4:3: error: stage text (test.sink): input 'table' is empty: maybe.table is optional"));
}

TEST_CASE("The manifest says how a result came about; a figure that is not a number is null there and in progress")
{
    RoomPlace place("\n  source: {type: test.source, value: 3}\n");
    place.make({"--cores", "1"});
    const Value manifest = manifest_in(object_with(place, "table"));
    CHECK(manifest.at("options").at("value").as_double() == 3);
    CHECK(manifest.at("report").at("threads").as_int() == 1);
    CHECK(manifest.at("versions").at("Testlib").as_string() == "1.2.3");
    CHECK(manifest.at("messages").as_list().size() == 1);
    CHECK(manifest.at("memory_mb").as_double() > 1);
    CHECK(manifest.find("processor") != nullptr);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));

    place.write_stages("\n  mean: {type: test.maybe}\n");
    const Finished finished = place.make({"--json-log", "--store", "other"});
    CHECK(manifest_in(place.objects("other").front()).at("report") ==
          Value(Value::Map{{"mean", Value()}, {"ranges", Value::Map{{"list", Value::List{1.5, Value()}}, {"count", 3}}}}));
    const std::vector<Value> progress = events(finished.out, "progress");
    REQUIRE(progress.size() == 1);
    CHECK(progress[0].at("done").as_double() == 1);
    CHECK(progress[0].at("metrics").at("loss").is_null());
}

TEST_CASE("Equal components are one object, a file goes through its reader")
{
    Workplace place;
    place.write("a.number", "7");
    place.write_stages(R"(
  scale: {type: test.scale, input: {table: {file: a.number}}, log: log}
  text:  {type: test.sink, input: scale, path: x.txt}
)");
    place.make();
    CHECK(place.read("out/x.txt") == "28.000000\n");
    CHECK(manifest_in(object_with(place, "scaled")).at("report").at("shared").as_bool());
}

TEST_CASE("A damaged result is named and made again in the same run; store verify finds it too")
{
    RoomPlace place;
    place.make();
    const fs::path source = object_with(place, "table");
    const auto damage = [&] { std::ofstream(source / "table/table.json") << R"({"columns":["value"],"rows":[[9]]})"; };
    damage();
    place.clear_log();
    const Finished repaired = place.make({"--set", "add.plus=2"});
    CHECK(contains(repaired.err, source.filename()));
    CHECK(contains(repaired.err, "damaged"));
    CHECK(place.read("out/x.txt") == "6.000000\n");
    CHECK(place.log().size() == 4);
    CHECK(place.run({"store", "verify"}).code == 0);
    damage();
    CHECK(contains(place.run({"store", "verify"}, 1).out, source.filename()));
}

TEST_CASE("A file that a result shares with its input is made again where it is damaged while the stage runs")
{
    RoomPlace place(R"(
  first:  {type: test.pass_mesh, log: log}
  second: {type: test.pass_mesh, input: first, damage: damaged, log: log}
)");
    CHECK(contains(place.make({"--cores", "1"}).err, "damaged"));
    CHECK(place.log().size() == 4);
    CHECK(place.run({"store", "verify"}).code == 0);
}

TEST_CASE("A damaged result that another run is already making again is left to that run")
{
    RoomPlace place;
    place.make();
    const fs::path source = object_with(place, "table");
    const fs::path table = source / "table/table.json";
    const std::string whole = fresco::read_text_file(table);
    std::ofstream(table) << "scribble";
    place.clear_log();
    // The other run: at work on the key until the result is whole again.
    FileLock other(place.file(".fresco/locks/" + manifest_in(source).at("key").as_string()));
    REQUIRE(other.try_exclusive());
    const auto run = place.start({"run", "room.yaml", "--set", "add.plus=2"});
    // For somebody who does not wait, time enough to spoil it.
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
    std::ofstream(table) << whole;
    other = FileLock();
    const Finished finished = run->wait();
    CHECK(finished.code == 0);
    CHECK(fresco::read_text_file(table) == whole);
    CHECK(place.logged("source") == 0);
}

TEST_CASE("A killed host takes its stages with it")
{
    RoomPlace place("\n  slow: {type: test.slow, steps: 100000, step_ms: 20, log: log}\n");
    const auto run = place.start({"run", "room.yaml"});
    wait_until([&] { return !place.log().empty(); });
    const fs::path stage = "/proc/" + std::to_string(run->a_child());
    run->signal(SIGKILL);
    CHECK(run->wait().code == -SIGKILL);
    // An ended process that is not reaped yet has no command line.
    wait_until([&] { return !fs::exists(stage) || fresco::read_text_file(stage / "cmdline").empty(); });
}

TEST_CASE("Of an absolute path the name of what it leads to is kept, wherever it stands")
{
    for (const auto& [text, expected] : std::map<std::string, std::string>{{"/home/ann/scan", "scan"},
                                                                           {"/home/ann lee/my scan", "my scan"},
                                                                           {"/home/ann/scan/", "scan/"},
                                                                           {"~ann/scan", "scan"},
                                                                           {"--in=/home/ann lee/x.png", "--in=x.png"},
                                                                           {"a /b/c --out /d/e", "a e"},
                                                                           {"file:///home/ann/x", "file:x"},
                                                                           {"input:data/scan", "input:data/scan"},
                                                                           {"https://host/page", "https://host/page"},
                                                                           {"1/2", "1/2"},
                                                                           {"/", ""}})
    {
        INFO(text);
        CHECK(without_folders(text) == expected);
    }
}

TEST_CASE("A stage learns how its result comes about, whatever the store still holds and wherever it lies, without paths")
{
    Workplace place;
    const std::string text = told(place);
    CHECK(text.find(place.root().string()) == std::string::npos);
    const Value origin = fresco::parse_json(text);
    CHECK(origin.at("versions").at("Testlib") == Value("1.2.3"));
    CHECK(origin.at("versions").find("fresco") != nullptr);

    CHECK(origin.at("stages") ==
          fresco::parse_json(R"([
        {"stage": "test.source", "options": {"beside": "", "file": {"file": "extra", "xxh128": ")" +
                             fresco::content_hash("123") +
                             R"("}, "folder": "scan", "value": 3.0}, "inputs": {}, "figures": {"threads": 1}},
        {"stage": "test.scale", "options": {"first": {"type": "test.factor", "factor": 2.0},
         "scaler": {"type": "test.factor", "factor": 2.0}}, "inputs": {"table": "test.source"}, "figures": {"shared": true}},
        {"stage": "test.add", "options": {"plus": 0.0}, "inputs": {"left": "test.scale", "right": "test.source"}},
        {"stage": "test.source 2", "options": {"beside": "", "file": "", "folder": "", "value": 4.0}, "inputs": {},
         "figures": {"threads": 1}},
        {"stage": "test.add 2", "options": {"plus": 0.0}, "inputs": {"left": "test.add", "right": "test.source 2"}},
        {"stage": "test.sink", "options": {"before": "", "copies": 0, "origin": true, "path": "origin.json"},
         "inputs": {"table": "test.add 2"}}])"));

    // Only the result that the stage reads stays.
    for (const auto& object : place.objects())
        if (manifest_in(object).at("stage") != Value("sum"))
            fs::remove_all(object);
    place.clear_log();
    CHECK(told(place) == text);
    CHECK(place.log() == Words{"sink origin.json"});
    Workplace elsewhere;
    CHECK(told(elsewhere) == text);
}

TEST_CASE("Times and long lists are no part of an origin")
{
    const Value reported = Value::Map{{"charts", 427},
                                      {"seconds_per_step", 0.4},
                                      {"wait_s", 2},
                                      {"mesh", "/home/ann/mesh.ply"},
                                      {"up", Value::List{0, 0, 1}},
                                      {"mean", Value()},
                                      {"judged", Value::Map{{"least", 150}, {"names", Value::List{1, 2, 3, 4, 5}}}},
                                      {"table", Value::Map{{"rows", Value::List{Value::List{1}}}}}};
    const Value origin = with_figures(Value::List{Value::Map{{"type", "a"}}}, reported);
    CHECK(origin.as_list()[0].at("figures") ==
          Value(Value::Map{
              {"charts", 427}, {"mesh", "mesh.ply"}, {"up", Value::List{0, 0, 1}}, {"judged", Value::Map{{"least", 150}}}}));
}

TEST_CASE("curves are kept within bounds and go back with their stage")
{
    const auto loss = [](double value) { return Value(Value::Map{{"loss", value}}); };
    MetricCurves curves;
    CHECK_FALSE(curves.add(0, Value::Map{}));
    CHECK(curves.to_value("steps").is_null());
    for (int step = 1; step <= 10'000; ++step)
        curves.add(step, loss(step));
    const auto& points = curves.points();
    CHECK(points.size() <= MetricCurves::most_points);
    CHECK(points.size() > MetricCurves::most_points / 3);
    CHECK(points.back().done > 9900);
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(points[i].done == 1 + static_cast<double>(i) * (points[1].done - 1));
    MetricCurves back;
    for (const int done : {1, 2, 3, 4, 2})
        back.add(done, loss(done * 10));
    back.add(3, Value::Map{{"loss", Value()}, {"other", 7}});
    CHECK(
        back.to_value("steps") ==
        fresco::parse_json(R"({"unit":"steps","done":[1.0,2.0,3.0],"metrics":{"loss":[10.0,20.0,null],"other":[null,null,7]}})"));
}
