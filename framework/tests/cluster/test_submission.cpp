#include "catch.h"
#include "cluster/slurm.h"
#include "cluster/submission.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>

#include <cstdlib>
#include <filesystem>

namespace
{

using namespace fresco::host;
namespace fs = std::filesystem;

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
        return run_program({{"bash", (wave / "submit.sh").string()},
                            "",
                            {{"PATH", folder.path().string() + ":" + std::getenv("PATH")}, {"QUEUE", folder.path().string()}}});
    }
    std::string jobs() const { return fresco::read_text_file(folder.path() / "jobs"); }

    fresco::testing::TemporaryFolder folder;
};

Wave wave_in(const fs::path& folder)
{
    Wave wave{folder, 0, {}, true};
    wave.arrays.push_back({"scan-0", "scan", {{0, 0, "scan@a"}, {1, 1, "scan@b"}}, {}, 5, 500, 2, false});
    wave.arrays.push_back({"paint-0", "paint", {{0, 2, "paint@a,x"}}, {{"scan-0", false, false, {0}}}, 40, 800, 1, true});
    wave.arrays.push_back({"paint-1",
                           "paint",
                           {{1, 3, "paint@b,x"}},
                           {{"scan-0", false, true, {}}, {"99", true, false, {4, 5}}},
                           40,
                           800,
                           1,
                           true});
    return wave;
}

}  // namespace

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
    CHECK(attempts.at(3).back().memory_mb == 800);
    CHECK(attempts.at(3).back().round == 1);
    CHECK(Submission(folder).round() == 1);
    CHECK(Submission(folder).next_wave() == 1);
    CHECK(fs::read_symlink(wave / "paint-1.1.log") == "../../logs/paint@b,x.log");
    const std::string script = fresco::read_text_file(wave / "paint-1.sbatch");
    CHECK(script.find("#SBATCH --partition=\"fast\"\n") != std::string::npos);
    CHECK(script.find("#SBATCH --cpus-per-task=1 --mem=800M --gres=gpu:1\n") != std::string::npos);
    CHECK(script.find("a folder, 100 %%/slurm/wave-000/paint-1.%a.log\"\n") != std::string::npos);
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
    CHECK(text.find("rule group_0: # scan: mesh, atlas\n") != std::string::npos);
    CHECK(
        text.find("    threads: 4\n    resources:\n        mem_mb=lambda wildcards, attempt: 1300 * 2 ** (attempt - 1),\n        "
                  "runtime=5,\n        gpu=0\n    retries: 2\n") != std::string::npos);
    CHECK(text.find("output: touch(\"done/scan,picture-gpu/{task}\")\n") != std::string::npos);
    CHECK(text.find("runtime=40,\n        gpu=1\n") != std::string::npos);
    CHECK(text.find(R"("task={wildcards.task}; " + "/usr/bin/fresco" + " run --task ${{task%%.*}} --cores {threads} ")") !=
          std::string::npos);
    CHECK(text.find("a {{b}} ") != std::string::npos);
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
