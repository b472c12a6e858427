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

Finished run_task(Workplace& place, int number)
{
    return place.run({"run", "--task", std::to_string(number), "tasks"});
}

void make_tasks(Workplace& place, const Words& more = {"--pack", "0"})
{
    Words words{"plan", "sweep.yaml", "--tasks", "--folder", "tasks"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished planned = place.run(words, 0);
}

}  // namespace

TEST_CASE("tasks run one by one come to what one run comes to, by the same keys", "[tasks]")
{
    Workplace place;
    place.write("sweep.yaml", scans_and_pictures);
    make_tasks(place);
    // Later changes of the file change no task.
    place.write("sweep.yaml", "version: 1\nstages: {}\n");
    for (int task = 0; task < 6; ++task)
    {
        const Finished finished = run_task(place, task);
        INFO(task << ": " << finished.err);
        REQUIRE(finished.code == 0);
        CHECK(place.logged("source") == static_cast<std::size_t>(std::min(task + 1, 2)));
    }
    CHECK(place.read("out/scan=1,plain/sum.txt") == "1011.000000\n");
    CHECK(place.read("out/scan=2,wild/sum.txt") == "1022.000000\n");
    CHECK_FALSE(fs::exists(place.file("out/sweep.json")));
    place.clear_log();
    place.write("sweep.yaml", scans_and_pictures);
    CHECK(place.run({"run", "sweep.yaml"}).code == 0);
    CHECK(place.log().empty());
    const Finished again = place.run({"plan", "sweep.yaml", "--tasks"});
    CHECK(fresco::parse_json(again.out, "tasks").at("task_count").as_int() == 0);
}

TEST_CASE("a task whose needs are missing says which task makes them, and makes none of it", "[tasks]")
{
    Workplace place;
    place.write("sweep.yaml", scans_and_pictures);
    make_tasks(place);
    const Finished early = run_task(place, 4);
    CHECK(early.code == 3);
    CHECK(contains(early.err, "task 4 needs mesh (scan=2), which task 1 makes: run it first"));
    CHECK(place.log().empty());
    REQUIRE(run_task(place, 1).code == 0);
    CHECK(run_task(place, 4).code == 0);
    CHECK(place.logged("source") == 1);
    // Another store lends what is missing.
    place.clear_log();
    fs::rename(place.file(".fresco"), place.file("other"));
    CHECK(place.run({"run", "--task", "4", "tasks", "--upstream", "other"}).code == 0);
    CHECK(place.log().empty());
    // What was stored when the tasks were made is made by none of them.
    fs::remove_all(place.file(".fresco"));
    fs::rename(place.file("other"), place.file(".fresco"));
    fs::remove_all(place.file("tasks"));
    make_tasks(place);
    fs::remove_all(place.file(".fresco"));
    CHECK(run_task(place, 1).code == 3);
}

TEST_CASE("of combinations in one task, one whose needs are missing stops only itself", "[tasks]")
{
    Workplace place;
    place.write("sweep.yaml", scans_and_pictures);
    make_tasks(place, {"--pack", "60"});
    REQUIRE(place.read_json("tasks/tasks.json").at("task_count").as_int() == 2);
    // The results of one of the two scans are lost.
    REQUIRE(run_task(place, 0).code == 0);
    for (const auto& object : place.objects())
        if (fresco::read_text_file(object / "manifest.json").find("mesh@scan=1") != std::string::npos)
            fs::remove_all(object);
    const Finished partly = run_task(place, 1);
    CHECK(partly.code == 3);
    CHECK(contains(partly.err, "task 1 needs mesh (scan=1), which task 0 makes: run it first"));
    CHECK(place.read("out/scan=2,plain/sum.txt") == "1012.000000\n");
    CHECK_FALSE(fs::exists(place.file("out/scan=1,plain")));
}

TEST_CASE("a task keeps the settings of its command line, and refuses another plugin than it was made with", "[tasks]")
{
    Workplace place;
    place.write("sweep.yaml", "version: 1\nvars: {n: 3}\nstages:\n  one: {type: test.source, value: \"${n}\", log: log}\n"
                              "  sum: {type: test.add, input: {left: one}, log: log}\n");
    make_tasks(place, {"--set", "n=7", "--without", "sum"});
    CHECK(run_task(place, 0).code == 0);
    CHECK(place.logged("add") == 0);
    fs::remove_all(place.file("tasks"));
    make_tasks(place, {"--set", "n=7"});
    CHECK(run_task(place, 0).code == 0);
    CHECK(place.run({"run", "sweep.yaml", "--set", "n=7"}).code == 0);
    CHECK(place.logged("source") == 1);

    std::string head = place.read("tasks/tasks.json");
    const std::size_t hash = head.find("\"hash\": \"", head.find("\"test.add\"")) + 9;
    head[hash] = head[hash] == '0' ? '1' : '0';
    place.write("tasks/tasks.json", head);
    const Finished other = run_task(place, 0);
    CHECK(other.code == 4);
    CHECK(contains(other.err, "the plugin of test.add, "));
    CHECK(contains(other.err, "make the tasks again"));
    CHECK(place.run({"run", "--task", "0", "tasks", "--set", "n=1"}).code == 2);
    CHECK(place.run({"plan", "sweep.yaml", "--tasks", "--upstream", "other"}).code == 2);
    CHECK(contains(run_task(place, 9).err, "no task 9: there are 0 to 0"));
    CHECK(contains(place.run({"run", "--task", "0", "elsewhere"}).err, "elsewhere: holds no tasks"));
}

TEST_CASE("what a stage needs while it runs is on the node's own disk, and goes away with it", "[tasks]")
{
    Workplace place({"good", "misbehaving"});
    place.environment["TMPDIR"] = place.file("node").string();
    fs::create_directories(place.file("node"));
    place.write_stages("\n  bad: {type: test.misbehave, how: loop}\n");
    const auto run = place.start({"run", "room.yaml"});
    Workplace::wait_until([&] { return !fs::is_empty(place.file("node")); });
    run->signal(SIGINT);
    run->signal(SIGTERM);  // Two of one kind would be one.
    CHECK(run->wait().code == 75);
    CHECK(fs::is_empty(place.file("node")));
    // A folder that is not there is no reason to fail.
    place.environment["TMPDIR"] = place.file("nowhere").string();
    place.write_stages("\n  bad: {type: test.misbehave, how: segfault}\n");
    CHECK(place.run({"run", "room.yaml"}).code == 1);
    CHECK(fs::is_empty(place.file(".fresco/tmp")));
}

TEST_CASE("a dry run needs no Slurm that answers; a submission does", "[tasks]")
{
    Workplace place;
    place.write("sweep.yaml", scans_and_pictures);
    for (const std::string name : {"scontrol", "squeue", "sbatch"})
    {
        place.write("bin/" + name, "#!/bin/sh\necho 'Unable to contact slurm controller'\nexit 1\n");
        fs::permissions(place.file("bin/" + name), fs::perms::owner_all);
    }
    place.environment["PATH"] = place.file("bin").string() + ":/usr/bin:/bin";
    const Finished dry = place.run({"submit", "slurm", "sweep.yaml", "--folder", "tasks", "--dry-run"}, 0);
    CHECK(contains(dry.out, "would submit"));
    CHECK(contains(dry.err, "Slurm does not answer here"));
    CHECK(contains(dry.err, "Unable to contact slurm controller"));
    CHECK(fs::exists(place.file("tasks/slurm/wave-000/submit.sh")));
    CHECK(contains(place.run({"submit", "slurm", "tasks"}, 1).err, "scontrol failed: Unable to contact slurm controller"));
}
