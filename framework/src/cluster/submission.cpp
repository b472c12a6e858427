#include "cluster/submission.h"
#include "base/common.h"
#include "base/records.h"
#include "base/text.h"
#include "cluster/submit.h"
#include "store/store.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <sstream>

namespace fresco::host
{

namespace
{

fs::path settings_file(const fs::path& folder)
{
    return folder / "slurm" / "settings.json";
}

std::size_t count_in(const Value& map, const char* name)
{
    return static_cast<std::size_t>(map.at(name).as_int());
}

std::vector<ArrayElement> elements_in(const fs::path& file)
{
    std::vector<ArrayElement> elements;
    std::istringstream text(read_text_file(file));
    for (std::string line; std::getline(text, line);)
    {
        std::istringstream words(line);
        ArrayElement element;
        if (!(words >> element.index >> element.task) || !std::getline(words >> std::ws, element.name))
            throw Error(file.string() + ": expected lines 'INDEX TASK NAME', found '" + line + "'");
        elements.push_back(std::move(element));
    }
    return elements;
}

/// Array and id, or "submitting".
std::map<std::string, std::string> jobs_in(const fs::path& file)
{
    std::map<std::string, std::string> jobs;
    if (!is_file(file))
        return jobs;
    std::istringstream text(read_text_file(file));
    for (std::string array, id; text >> array >> id;)
        jobs[array] = id;
    return jobs;
}

bool contains_any(const std::string& text, std::initializer_list<const char*> parts)
{
    return std::ranges::any_of(parts, [&](const char* part) { return text.find(part) != std::string::npos; });
}

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
    const JobLimits limits = limits_of(group, nullptr, {});
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
                       fmt::arg("threads", limits.threads), fmt::arg("memory", limits.memory_mb),
                       fmt::arg("minutes", limits.minutes), fmt::arg("gpu", group.gpu ? 1 : 0));
}

}  // namespace

bool Submission::is_at(const fs::path& folder)
{
    return is_file(settings_file(folder));
}

void Submission::configure(const fs::path& folder, const SlurmSettings& settings)
{
    make_folder(folder / "slurm");
    write_record(settings_file(folder), Value::Map{{"version", 1},
                                                   {"run", settings.run},
                                                   {"program", settings.program.string()},
                                                   {"partition", settings.partition},
                                                   {"gpu_partition", settings.gpu_partition},
                                                   {"max_queued", settings.max_queued}});
}

Submission::Submission(fs::path folder) : folder_(std::move(folder))
{
    if (!is_at(folder_))
        throw MissingInput(folder_.string() + ": nothing was submitted to Slurm from this folder; `fresco submit slurm` does so");
    const Value settings = read_record(settings_file(folder_));
    settings_ = {.run = settings.at("run").as_string(),
                 .program = settings.at("program").as_string(),
                 .partition = settings.at("partition").as_string(),
                 .gpu_partition = settings.at("gpu_partition").as_string(),
                 .max_queued = count_in(settings, "max_queued")};
    for (const fs::path& entry : entries_of(folder_ / "slurm"))
        if (is_file(entry / "wave.json"))
            waves_.push_back(read_wave(entry));
    std::ranges::sort(waves_, {}, &WrittenWave::number);
}

Submission::WrittenWave Submission::read_wave(const fs::path& folder)
{
    const Value record = read_record(folder / "wave.json");
    const auto jobs = jobs_in(folder / "jobs");
    WrittenWave wave{count_in(record, "number"), count_in(record, "round"), !jobs.empty(), {}};
    for (const Value& array : record.at("arrays").as_list())
    {
        const std::string& name = array.at("name").as_string();
        const auto job = jobs.find(name);
        const JobLimits limits{static_cast<int>(array.at("minutes").as_int()), static_cast<int>(array.at("memory_mb").as_int())};
        wave.arrays.push_back({{name, elements_in(folder / (name + ".list")), {}, limits},
                               job == jobs.end() || job->second == "submitting" ? "" : job->second});
    }
    return wave;
}

std::map<std::size_t, std::vector<Attempt>> Submission::attempts(const SlurmQueue& queue) const
{
    std::map<std::size_t, std::vector<Attempt>> result;
    for (const WrittenWave& wave : waves_)
        for (const auto& [array, written_job] : wave.arrays)
        {
            std::string job = written_job;
            if (const auto found = queue.jobs.find(job_name(settings_, wave.number, array.name));
                job.empty() && found != queue.jobs.end())
                job = found->second;
            if (!job.empty())
                for (const ArrayElement& element : array.elements)
                    result[element.task].push_back({{job, element.index}, wave.round, array.limits});
        }
    return result;
}

void Submission::write(const Wave& wave, std::size_t round)
{
    for (const WrittenWave& written : waves_)
        if (!written.begun && written.number != wave.number)
            remove_quietly(folder_ / wave_folder(written.number));
    const fs::path folder = folder_ / wave_folder(wave.number);
    remove_quietly(folder);
    make_folder(folder);
    make_folder(folder_ / "logs");
    Value::List arrays;
    for (const JobArray& array : wave.arrays)
    {
        write_file(folder / (array.name + ".sbatch"), array_script(settings_, wave, array));
        write_file(folder / (array.name + ".list"), array_list(array));
        for (const ArrayElement& element : array.elements)
            make_link(fs::path("../../logs") / (element.name + ".log"),
                      folder / (array.name + "." + std::to_string(element.index) + ".log"));
        arrays.push_back(
            Value::Map{{"name", array.name}, {"minutes", array.limits.minutes}, {"memory_mb", array.limits.memory_mb}});
    }
    if (wave.continued)
        write_file(folder / "continue.sbatch", continuing_script(settings_, wave));
    write_file(folder / "submit.sh", submit_script(settings_, wave));
    fs::permissions(folder / "submit.sh", fs::perms::owner_exec | fs::perms::group_exec, fs::perm_options::add);
    write_record(folder / "wave.json", Value::Map{{"number", wave.number}, {"round", round}, {"arrays", std::move(arrays)}});
}

std::string task_name(const TaskTable& table, const Task& task)
{
    const TaskGroup& group = table.groups.at(task.group);
    std::string name = group.name;
    for (std::size_t i = 0; i < task.axes.size(); ++i)
        name += (i == 0 ? "@" : ",") + task.axes[i].second;
    return task.axes.size() == group.axes.size() ? name : name + "." + std::to_string(task.id);
}

TaskLog last_log(const fs::path& folder, const std::string& task_name)
{
    TaskLog log{folder / "logs" / (task_name + ".log"), "", ""};
    if (!is_file(log.file))
        return log;
    const std::string text = read_text_file(log.file);
    const std::string head = "== task ";
    const std::size_t begin = text.starts_with(head) && text.find("\n" + head) == std::string::npos ? 0 : text.rfind("\n" + head);
    if (begin == std::string::npos)
        return log;
    log.text = text.substr(begin);
    const std::string before_job = "), job ";
    if (const std::size_t job = log.text.find(before_job); job != std::string::npos)
        log.job = log.text.substr(job + before_job.size(), log.text.find(' ', job + before_job.size()) - job - before_job.size());
    return log;
}

bool TaskLog::memory_ran_out() const
{
    // Slurm's words with and without control groups, and fresco's own about the process of a stage.
    return contains_any(text,
                        {"oom-kill", "oom_kill", "exceeded memory limit", "exceeded job memory limit", "ran out of memory"});
}

bool TaskLog::time_ran_out() const
{
    return contains_any(text, {"DUE TO TIME LIMIT"});
}

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
