#include "base/common.h"
#include "catch.h"
#include "cluster/job_arrays.h"
#include "cluster/slurm.h"
#include "cluster/submission.h"
#include "cluster/submit.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <numeric>

namespace
{

using namespace fresco::host;
namespace fs = std::filesystem;
using Numbers = std::vector<std::size_t>;

QueuedTask task(std::size_t number, const std::string& group, std::vector<std::size_t> needs = {})
{
    return {number, group, fmt::format("{}@{}", group, number), std::move(needs), {10, 500, 1, false}};
}

/// For each task of a submission that can run, the tasks that the scheduler makes it wait for.
std::map<std::size_t, std::set<std::size_t>> told(const std::vector<JobArray>& arrays)
{
    std::map<std::string, std::map<std::size_t, std::size_t>> tasks;
    std::map<std::size_t, std::set<std::size_t>> result;
    for (const JobArray& array : arrays)
    {
        for (const ArrayElement& element : array.elements)
        {
            CHECK(tasks[array.name].emplace(element.index, element.task).second);
            auto& waits = result[element.task];
            for (const ArrayDependency& dependency : array.dependencies)
            {
                const auto& other = tasks.at(dependency.array);
                if (dependency.corresponding)
                    waits.insert(other.at(element.index));
                else if (dependency.elements.empty())
                    for (const auto& [index, number] : other)
                        waits.insert(number);
                for (const std::size_t index : dependency.elements)
                    waits.insert(other.at(index));
            }
        }
    }
    return result;
}

/// A scheduler that gives ids from 101 on and remembers names; it kills who asks it for the array in the file "deadly", once,
/// after queueing it.
const char* const sbatch = R"~(#!/usr/bin/env bash
file=${!#} dependency=
for word in "$@"; do case $word in --dependency=*) dependency=${word#*=} ;; esac; done
name=$(sed -n 's/^#SBATCH --job-name=//p' "$file")
id=$((101 + $(cat "$QUEUE/jobs" 2>/dev/null | wc -l)))
echo "$id $name $dependency" >>"$QUEUE/jobs"
if [ -e "$QUEUE/deadly" ] && [ "${file%.sbatch}" = "$(cat "$QUEUE/deadly")" ]; then
    rm "$QUEUE/deadly"
    kill -9 $PPID
fi
echo "$id;cluster"
)~";
const char* const squeue = R"~(#!/usr/bin/env bash
for word in "$@"; do case $word in --name=*) name=${word#*=} ;; esac; done
awk -v name="$name" '$2 == name { print $1 }' "$QUEUE/jobs"
)~";

struct FakeSlurm
{
    FakeSlurm()
    {
        for (const auto& [name, text] : {std::pair("sbatch", sbatch), std::pair("squeue", squeue)})
        {
            fresco::write_file(folder.path() / name, std::string_view(text));
            fs::permissions(folder.path() / name, fs::perms::owner_all);
        }
    }

    ProgramEnd submit(const fs::path& wave) const
    {
        return run_program(
            {.file = {},
             .arguments = {"bash", (wave / "submit.sh").string()},
             .environment = {{"PATH", folder.path().string() + ":" + std::getenv("PATH")}, {"QUEUE", folder.path().string()}}});
    }
    std::string jobs() const { return fresco::read_text_file(folder.path() / "jobs"); }

    fresco::testing::TemporaryFolder folder;
};

Wave wave_in(const fs::path& folder)
{
    Wave wave{folder, 0, {}, true};
    wave.arrays.push_back({"scan-0", {{0, 0, "scan@a"}, {1, 1, "scan@b"}}, {}, {5, 500, 2, false}});
    wave.arrays.push_back({"paint-0", {{0, 2, "paint@a,x"}}, {{"scan-0", false, false, {0}}}, {40, 800, 1, true}});
    wave.arrays.push_back(
        {"paint-1", {{1, 3, "paint@b,x"}}, {{"scan-0", false, true, {}}, {"99", true, false, {4, 5}}}, {40, 800, 1, true}});
    return wave;
}

}  // namespace

TEST_CASE("a task waits for exactly what it needs, in few arrays")
{
    std::vector<QueuedTask> tasks;
    const auto add = [&](std::size_t count, const std::string& group, const auto& needs)
    {
        for (std::size_t i = 0; i < count; ++i)
            tasks.push_back(task(tasks.size(), group, needs(i)));
    };
    const auto nothing = [](std::size_t) { return Numbers{}; };
    std::size_t array_size = 1001;
    std::size_t count = 0;
    SECTION("pictures of scans: an array per scan")
    {
        add(5, "scan", nothing);
        add(100, "scan+picture", [](std::size_t i) { return Numbers{i / 20}; });
        count = 6;
    }
    SECTION("a preparation of its own for each: two arrays")
    {
        add(30, "scan", nothing);
        add(30, "paint", [](std::size_t i) { return Numbers{29 - i}; });
        count = 2;
    }
    SECTION("scans and pictures that are both prepared: an array per scan, whose elements follow the pictures")
    {
        add(3, "scan", nothing);
        add(8, "picture", nothing);
        add(24, "paint", [](std::size_t i) { return Numbers{i / 8, 3 + i % 8}; });
        count = 5;
    }
    SECTION("one that needs all others, and no index beyond the largest")
    {
        add(25, "scan", nothing);
        Numbers all(25);
        std::iota(all.begin(), all.end(), 0);
        tasks.push_back(task(25, "once", all));
        array_size = 10;
        count = 4;
    }
    SECTION("tasks with other limits are in arrays of their own")
    {
        add(4, "scan", nothing);
        tasks[2].limits.memory_mb = 1000;
        count = 2;
    }
    const auto arrays = job_arrays(tasks, {}, array_size);
    CHECK(arrays.size() == count);
    for (const auto& array : arrays)
        for (const auto& element : array.elements)
        {
            CHECK(element.index < array_size);
            CHECK(array.limits == tasks.at(element.task).limits);
        }
    const auto waits = told(arrays);
    REQUIRE(waits.size() == tasks.size());
    for (const QueuedTask& one : tasks)
        CHECK(waits.at(one.number) == std::set<std::size_t>(one.needs.begin(), one.needs.end()));
}

TEST_CASE("a task follows one that is in the queue already, and does not wait for one that is done")
{
    const auto arrays = job_arrays({task(5, "paint", {0, 1}), task(6, "paint", {2})}, {{1, {"77", 4, true}}}, 1001);
    REQUIRE(arrays.size() == 2);
    REQUIRE(arrays[0].dependencies.size() == 1);
    CHECK(arrays[0].dependencies[0].array == "77");
    CHECK(arrays[0].dependencies[0].queued_before);
    CHECK(arrays[1].dependencies.empty());
    CHECK(arrays[1].elements.at(0).task == 6);
}

TEST_CASE("indices are written as ranges")
{
    CHECK(index_ranges({{0, 0, ""}, {1, 0, ""}, {2, 0, ""}, {5, 0, ""}, {7, 0, ""}, {8, 0, ""}}) == "0-2,5,7-8");
    CHECK(index_ranges({{3, 0, ""}}) == "3");
}

TEST_CASE("what is missing is queued in the order of its needs, as much as there is room for")
{
    const fresco::testing::TemporaryFolder folder;
    TaskTable table;
    table.groups = {{"scan", {"scan"}, false, {"mesh"}, {}, 0, 2, 100, 1000, 4},
                    {"scan,picture", {"scan", "picture"}, true, {"texture"}, {0}, 2, 4, 1200, 100, 2}};
    table.tasks = {{0, 0, {"mesh@a"}, {{"scan", "a"}}, {}, 100, 1000},
                   {1, 0, {"mesh@b"}, {{"scan", "b"}}, {}, 100, 1000},
                   {2, 1, {"texture@a,x"}, {{"scan", "a"}, {"picture", "x"}}, {0}, 1200, 100},
                   {3, 1, {"texture@a,y"}, {{"scan", "a"}, {"picture", "y"}}, {0}, 1200, 100},
                   {4, 1, {"texture@b,x"}, {{"scan", "b"}, {"picture", "x"}}, {1}, 1200, 100},
                   {5, 1, {"texture@b,y", "texture@b,z"}, {{"scan", "b"}}, {1}, 1200, 100}};
    TaskKnowledge known;
    known.done.resize(6);
    const auto numbers = [](const MissingTasks& missing) { return each(missing.tasks, &QueuedTask::number); };

    const auto all = missing_tasks(table, known, folder.path(), 1, 100);
    CHECK(numbers(all) == Numbers{0, 1, 2, 3, 4, 5});
    CHECK(all.tasks[0].name == "scan@a");
    CHECK(all.tasks[0].limits == JobLimits{5, 1300, 4, false});
    CHECK(all.tasks[2].group == "scan+picture");
    CHECK(all.tasks[2].limits == JobLimits{40, 500, 2, true});
    CHECK(all.tasks[5].name == "scan,picture@b.5");

    const auto some = missing_tasks(table, known, folder.path(), 1, 3);
    CHECK(numbers(some) == Numbers{0, 1, 2});
    CHECK(some.left == 3);

    // a is done, b failed in this round: what needs it is not queued.
    known.done[0] = true;
    known.attempts[0] = {{{"7", 0}, 1, 5, 1300}};
    known.attempts[1] = {{{"7", 1}, 1, 5, 1300}};
    const auto rest = missing_tasks(table, known, folder.path(), 1, 100);
    CHECK(numbers(rest) == Numbers{2, 3});
    CHECK(rest.blocked == 3);

    // Asked for again, it is queued again; with more memory where that ran out.
    CHECK(numbers(missing_tasks(table, known, folder.path(), 2, 100)) == Numbers{1, 2, 3, 4, 5});
    std::filesystem::create_directory(folder.path() / "logs");
    fresco::write_file(folder.path() / "logs" / "scan@b.log",
                       "== task 1 (scan@b), job 7_1 on n, start 1\nslurmstepd: error: Detected 1 "
                       "oom-kill event(s) in step 7.batch\n");
    CHECK(missing_tasks(table, known, folder.path(), 2, 100).tasks.at(0).limits.memory_mb == 2600);

    // Still in the queue: others wait for it there.
    known.queue.elements[{"7", 1}] = "RUNNING";
    const auto beside = missing_tasks(table, known, folder.path(), 2, 100);
    CHECK(numbers(beside) == Numbers{2, 3, 4, 5});
    CHECK(beside.queued.at(1) == ElementPlace{"7", 1, true});
}

TEST_CASE("the scheduler's answers are read")
{
    const SlurmLimits limits = limits_in("MaxArraySize            = 101\nMaxJobCount             = 5000\nMaxJobId = 67043328\n");
    CHECK(limits.array_size == 101);
    CHECK(limits.job_count == 5000);
    CHECK(limits_in("").array_size == 1001);
    const SlurmQueue queue = queue_in("12 0 RUNNING fresco-1.0.scan-0\n12 1 PENDING fresco-1.0.scan-0\n13 N/A PENDING "
                                      "fresco-1.0.continue\n14 0 RUNNING fresco-12.0.scan-0\n",
                                      "fresco-1");
    CHECK(queue.elements.size() == 2);
    CHECK(queue.elements.at({"12", 1}) == "PENDING");
    CHECK(queue.jobs.at("fresco-1.0.continue") == "13");
    CHECK(queue.jobs.size() == 2);
}

TEST_CASE("a wave is submitted once, whenever its script is killed")
{
    const FakeSlurm slurm;
    const fresco::testing::TemporaryFolder place;
    const fs::path folder = place.path() / "a folder, 100 %";
    Submission::configure(folder, {.run = "fresco-1", .program = "/usr/bin/fresco", .partition = "cpu", .gpu_partition = "fast"});
    Submission submission(folder);
    submission.write(wave_in(folder), 1);
    const fs::path wave = folder / "slurm" / "wave-000";
    const std::string deadly = GENERATE("", "scan-0", "paint-1", "continue");
    if (!deadly.empty())
    {
        fresco::write_file(slurm.folder.path() / "deadly", deadly);
        CHECK(slurm.submit(wave).exit_code != 0);
    }
    for (int i = 0; i < 2; ++i)
    {
        const ProgramEnd end = slurm.submit(wave);
        INFO(end.output);
        CHECK(end.exit_code == 0);
        CHECK(slurm.jobs() == "101 fresco-1.0.scan-0 \n"
                              "102 fresco-1.0.paint-0 afterok:101_0\n"
                              "103 fresco-1.0.paint-1 aftercorr:101,afterok:99_4:99_5\n"
                              "104 fresco-1.0.continue afterany:101\n");
    }
    const auto attempts = Submission(folder).attempts({});
    REQUIRE(attempts.size() == 4);
    CHECK(attempts.at(3).back().element == ElementId{"103", 1});
    CHECK(attempts.at(3).back().limits.memory_mb == 800);
    CHECK(attempts.at(3).back().round == 1);
    CHECK(Submission(folder).round() == 1);
    CHECK(Submission(folder).next_wave() == 1);
    CHECK(fs::read_symlink(wave / "paint-1.1.log") == "../../logs/paint@b,x.log");
    const std::string script = fresco::read_text_file(wave / "paint-1.sbatch");
    for (const char* line : {"#SBATCH --partition=\"fast\"\n", "#SBATCH --cpus-per-task=1 --mem=800M --gres=gpu:1\n",
                             "a folder, 100 %%/slurm/wave-000/paint-1.%a.log\"\n"})
        CHECK_THAT(script, Catch::Contains(line));
}

TEST_CASE("an array whose id was not written is found by its name; a wave that was not submitted does not count")
{
    const fresco::testing::TemporaryFolder place;
    Submission::configure(place.path(), {.run = "fresco-1", .program = "/usr/bin/fresco"});
    Submission submission(place.path());
    submission.write(wave_in(place.path()), 1);
    fresco::write_file(place.path() / "slurm/wave-000/jobs", "scan-0 submitting\n");
    SlurmQueue queue;
    queue.jobs["fresco-1.0.scan-0"] = "7";
    const auto attempts = Submission(place.path()).attempts(queue);
    CHECK(attempts.size() == 2);
    CHECK(attempts.at(1).back().element == ElementId{"7", 1});
    CHECK(Submission(place.path()).attempts({}).empty());

    fs::remove(place.path() / "slurm/wave-000/jobs");
    Submission again(place.path());
    Wave next = wave_in(place.path());
    next.number = again.next_wave();
    again.write(next, 1);
    CHECK(!fs::exists(place.path() / "slurm/wave-000"));
    CHECK(fs::exists(place.path() / "slurm/wave-001/wave.json"));
}

TEST_CASE("the log of a task shows its last attempt")
{
    const fresco::testing::TemporaryFolder place;
    CHECK(last_log(place.path(), "scan@a").job.empty());
    fs::create_directory(place.path() / "logs");
    fresco::write_file(place.path() / "logs/scan@a.log",
                       "== task 0 (scan@a), job 7_0 on n, start 1, 2026\nslurmstepd: error: oom-kill event\n"
                       "== task 0 (scan@a), job 9_3 on n, start 1, 2026\nerror: JOB 12 CANCELLED DUE TO TIME LIMIT\n");
    const TaskLog log = last_log(place.path(), "scan@a");
    CHECK(log.job == "9_3");
    CHECK(log.time_ran_out());
    CHECK(!log.memory_ran_out());
}

TEST_CASE("a Snakefile has a rule per group, with its resources")
{
    TaskTable table;
    table.groups = {{"scan", {"scan"}, false, {"mesh", "atlas"}, {}, 0, 2, 100, 1000, 4},
                    {"scan,picture-gpu", {"scan", "picture"}, true, {"texture"}, {0}, 2, 4, 1200, 100, 2}};
    const std::string text = snakefile(table, "/data/a {b} 'c'", "/usr/bin/fresco");
    for (const char* part :
         {"rule group_0: # scan: mesh, atlas\n",
          "    threads: 4\n    resources:\n        mem_mb=lambda wildcards, attempt: 1300 * 2 ** (attempt - 1),\n        "
          "runtime=5,\n        gpu=0\n    retries: 2\n",
          "output: touch(\"done/scan,picture-gpu/{task}\")\n", "runtime=40,\n        gpu=1\n",
          R"("task={wildcards.task}; " + "/usr/bin/fresco" + " run --task ${{task%%.*}} --cores {threads} ")", "a {{b}} "})
        CHECK_THAT(text, Catch::Contains(part));
}

TEST_CASE("what a program printed begins no line of a message")
{
    const auto quoted = [](const std::string& output) { return ProgramEnd{1, output}.quoted_output(); };
    CHECK(quoted("no controller\n") == " no controller");
    CHECK(quoted("") == " ");
    CHECK(quoted("one\nerror: two\n") == "\n    | one\n    | error: two");
}

TEST_CASE("nothing from users begins a command in a script")
{
    const std::string evil = GENERATE("a\ntouch gone\n#", "a\rb", "a\x1b[2J",
                                      "a\xe2\x80\xae"
                                      "b",
                                      "a\xff");
    const fs::path program = "/usr/bin/fresco";
    const fs::path folder = "/work";
    const auto refused = [](const auto& write, const std::string& name)
    { CHECK_THROWS_WITH(write(), Catch::StartsWith(name + ": '") && Catch::Contains("UTF-8 text without control characters")); };
    const auto scripts = [&](const SlurmSettings& settings, const fs::path& place, const std::string& name)
    {
        const Wave wave = wave_in(place);
        refused([&] { return array_script(settings, wave, wave.arrays.front()); }, name);
        refused([&] { return continuing_script(settings, wave); }, name);
    };
    scripts({"fresco-1", program, "cpu", "fast", 0}, folder / evil, "--folder");
    scripts({"fresco-1", program, evil, "fast", 0}, folder, "--partition");
    scripts({"fresco-1", program, "cpu", evil, 0}, folder, "--gpu-partition");
    scripts({"fresco-1", folder / evil / "fresco", "cpu", "fast", 0}, folder, "the path of fresco");
    refused([&] { return snakefile({}, folder / evil, program); }, "--folder");
    refused([&] { return snakefile({}, folder, folder / evil / "fresco"); }, "the path of fresco");
}
