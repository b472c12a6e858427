#include "cluster/snakefile.h"
#include "base/unit_text.h"
#include "cluster/missing_tasks.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <fmt/format.h>

namespace fresco::host
{
namespace
{

/// As Python and Snakemake read it, who take braces for names of their own.
std::string python_text(const std::string& text)
{
    std::string result = to_json(text);
    for (std::size_t at = 0; (at = result.find_first_of("{}", at)) != std::string::npos; at += 2)
        result.insert(at, 1, result[at]);
    return result;
}

std::string rule(const TaskGroup& group, std::size_t number)
{
    QueuedTask limits;
    set_limits(limits, group, nullptr, {});
    return fmt::format(R"~(
rule group_{number}: # {name}: {stages}
    input: needs
    output: touch("done/{name}/{{task}}")
    log: "logs/{{task}}.log"
    threads: {threads}
    resources:
        mem_mb=lambda wildcards, attempt: {memory} * 2 ** (attempt - 1),
        runtime={minutes},
        gpu={gpu}
    retries: 2
    shell: RUN
)~",
                       fmt::arg("number", number), fmt::arg("name", group.name), fmt::arg("stages", join(group.stages, ", ")),
                       fmt::arg("threads", group.threads), fmt::arg("memory", limits.memory_mb),
                       fmt::arg("minutes", limits.minutes), fmt::arg("gpu", group.gpu ? 1 : 0));
}

}  // namespace

std::string snakefile(const TaskTable& head, const std::filesystem::path& folder, const std::filesystem::path& program)
{
    for (const auto& [name, path] : {std::pair("--folder", folder), std::pair("the path of fresco", program)})
        if (const std::string problem = script_problem(name, path.string()); !problem.empty())
            throw Error(problem);
    std::string text = fmt::format(R"~(# On this machine:    snakemake --snakefile {file} --cores 8
# On a cluster:       snakemake --snakefile {file} --jobs 100 --cluster \
#   "sbatch --mem={{resources.mem_mb}} --time={{resources.runtime}} --cpus-per-task={{threads}} --gres=gpu:{{resources.gpu}}"
import json
import pathlib
import re

workdir: workflow.basedir

folder = pathlib.Path(workflow.basedir)
groups = json.loads((folder / "tasks.json").read_text())["groups"]
tasks = [task for chunk in sorted((folder / "tasks").glob("*.json")) for task in json.loads(chunk.read_text())["tasks"]]


def name_of(task):
    """Its number and axes. Snakemake allows no ',', '=' or ':' in the names of a cluster's jobs."""
    axes = ",".join(task["axes"].values()) or groups[task["group"]]["name"]
    return f"{{task['id']}}." + re.sub(r"[^\w.-]+", "-", axes)


done = [f"done/{{groups[task['group']]['name']}}/{{name_of(task)}}" for task in tasks]


def needs(wildcards):
    return [done[need] for need in tasks[int(wildcards.task.partition(".")[0])]["needs"]]


RUN = "task={{wildcards.task}}; " + {run} + " run --task ${{{{task%%.*}}}} --cores {{threads}} " + {folder} + " >>{{log:q}} 2>&1"

wildcard_constraints: task="[^/]+"
localrules: collect


rule collect:
    input: done
    output: touch("done/collect")
    shell: {run} + " collect " + {folder}
)~",
                                   fmt::arg("file", shell_word((folder / "Snakefile").string())),
                                   fmt::arg("run", python_text(shell_word(program.string()))),
                                   fmt::arg("folder", python_text(shell_word(folder.string()))));
    for (std::size_t i = 0; i < head.groups.size(); ++i)
        text += rule(head.groups[i], i);
    return text;
}

}  // namespace fresco::host
