#include "program.h"

namespace
{

/// Two scans that are prepared, each painted with two pictures.
const char* const scans_and_pictures = R"(version: 1
vars: {scan: , picture: , how: nothing}
matrix: {scan: [1, 2], picture: {plain: 10, wild: 20}}
stages:
  scan_of: {type: test.source, value: "${scan}", log: log}
  mesh:    {type: test.add, input: {left: scan_of}, plus: 1000, log: log}
  paint:   {type: test.add, input: {left: mesh}, plus: "${picture}", log: log}
  text:    {type: test.sink, input: paint, path: sum.txt, log: log}
)";

/// A workplace with the matrix as room.yaml.
struct MatrixPlace : RoomPlace
{
    MatrixPlace() : RoomPlace(scans_and_pictures) {}
    Finished run_task(const std::string& name, int code = 0) { return run({"run", "room.yaml", "--task", name}, code); }
    Value::List tasks(Words more = {})
    {
        more.insert(more.begin(), {"plan", "room.yaml", "--tasks", "--cores", "3"});
        return fresco::parse_json(run(more, 0).out, "tasks").at("tasks").as_list();
    }
};

std::vector<std::string> names_of(const Value::List& tasks)
{
    return each(tasks, [](const Value& task) { return task.at("name").as_string(); });
}

}  // namespace

TEST_CASE("the tasks of a matrix are one for each combination of the axes that its stages share", "[tasks]")
{
    MatrixPlace place;
    const Value::List tasks = place.tasks();
    CHECK(names_of(tasks) == Words{"scan@scan=1", "scan@scan=2", "scan,picture@scan=1,plain", "scan,picture@scan=1,wild",
                                   "scan,picture@scan=2,plain", "scan,picture@scan=2,wild"});
    // Both stages declare 30 MB.
    CHECK(to_json(tasks[1]) == R"({"name":"scan@scan=2","stages":["scan_of@scan=2","mesh@scan=2"],"needs":[],"gpu":false,)"
                               R"("done":false,"threads":3,"minutes":null,"mem_mb":30.0})");
    CHECK(to_json(tasks[4].at("needs")) == R"(["scan@scan=2"])");
    CHECK(names_of(place.tasks({"--until", "mesh"})) == Words{"scan@scan=1", "scan@scan=2"});
    CHECK(names_of(place.tasks({"--set", "scan=2"})) ==
          Words{"scan@scan=2", "scan,picture@scan=2,plain", "scan,picture@scan=2,wild"});
    // Names do not depend on what is stored.
    place.run_task("scan@scan=2");
    const Value::List again = place.tasks();
    CHECK(names_of(again) == names_of(tasks));
    CHECK_FALSE(again[0].at("done").as_bool());
    CHECK(again[1].at("done").as_bool());
    CHECK(again[1].at("minutes").as_double() == 1);
    CHECK(again[1].at("mem_mb").as_double() > 0);
}

TEST_CASE("tasks run one by one come to what one run comes to, by the same keys", "[tasks]")
{
    MatrixPlace place;
    const Words tasks = names_of(place.tasks());
    place.write("copy.yaml", scans_and_pictures);
    // Later changes of the file change no task of the copy.
    place.write("room.yaml", "version: 1\nstages: {}\n");
    for (std::size_t i = 0; i < tasks.size(); ++i)
    {
        place.make({"--task", tasks[i], "--text", "copy.yaml"});
        CHECK(place.logged("source") == std::min<std::size_t>(i + 1, 2));
    }
    CHECK(place.read("out/scan=1,plain/sum.txt") == "1011.000000\n");
    CHECK(place.read("out/scan=2,wild/sum.txt") == "1022.000000\n");
    CHECK_FALSE(fs::exists(place.file("out/sweep.json")));
    place.clear_log();
    place.write("room.yaml", scans_and_pictures);
    place.run_task(tasks[5]);
    place.make();
    CHECK(place.log().empty());
}

TEST_CASE("a task whose needs are missing says which task makes them, and makes none of it", "[tasks]")
{
    MatrixPlace place;
    CHECK(contains(place.run_task("scan,picture@scan=2,plain", 3).err,
                   "task scan,picture@scan=2,plain needs the result of mesh@scan=2: run task scan@scan=2 first"));
    CHECK(place.log().empty());
    place.run_task("scan@scan=2");
    place.run_task("scan,picture@scan=2,plain");
    CHECK(place.logged("source") == 1);
    CHECK(contains(place.run_task("scan@scan=3", 1).err, "--task scan@scan=3: unknown task (did you mean 'scan@scan=1'?)"));
}

TEST_CASE("what is stored is written out without running a stage, and what is missing is named", "[tasks]")
{
    MatrixPlace place;
    place.run_task("scan@scan=1");
    place.run_task("scan,picture@scan=1,plain");
    for (const bool whole : {false, true})
    {
        fs::remove_all(place.file("out"));
        place.clear_log();
        const Finished stored = place.run({"run", "room.yaml", "--only-stored"}, whole ? 0 : 3);
        CHECK((whole || contains(stored.err, "have no cached result, such as ")));
        CHECK(place.read("out/scan=1,plain/sum.txt") == "1011.000000\n");
        CHECK(place.read("out/scan=2,wild/sum.txt") == (whole ? "1022.000000\n" : ""));
        CHECK(fs::exists(place.file("out/sweep.json")));
        CHECK(place.log().empty());
        place.make();
    }
}
