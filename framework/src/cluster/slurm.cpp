#include "cluster/slurm.h"
#include "base/common.h"
#include "base/text.h"
#include <fresco/error.h>

#include <boost/algorithm/string/replace.hpp>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sstream>
#include <unistd.h>

namespace fresco::host
{

namespace
{

/// Seconds that the stages have to write their checkpoints before the time limit.
constexpr int warning_seconds = 60;
/// After as many interruptions a task counts as failed.
constexpr int most_requeues = 20;
constexpr const char* continuing_name = "continue";

/// In a file name of Slurm's, which has patterns.
std::string literal(const std::string& path)
{
    return boost::replace_all_copy(path, "%", "%%");
}

/// In the double quotes that #SBATCH lines know.
std::string quoted(const std::string& text)
{
    std::string result = "\"";
    for (const char c : text)
        result += (c == '"' || c == '\\' ? std::string("\\") : std::string()) + c;
    return result + "\"";
}

/// How the names of a wave's jobs begin.
std::string names_of(const SlurmSettings& settings, std::size_t wave)
{
    return fmt::format("{}.{}", settings.run, wave);
}

std::string head(const SlurmSettings& settings, const Wave& wave, const std::string& name, const std::string& partition)
{
    if (const std::string problem = script_problem(settings, wave.folder); !problem.empty())
        throw Error(problem);
    return fmt::format("#!/usr/bin/env bash\n"
                       "#SBATCH --job-name={}\n"
                       "#SBATCH --chdir={}\n"
                       "{}"
                       "#SBATCH --nodes=1 --ntasks=1\n",
                       job_name(settings, wave.number, name), quoted(wave.folder.string()),
                       partition.empty() ? "" : "#SBATCH --partition=" + quoted(partition) + "\n");
}

std::string dependency_text(const ArrayDependency& dependency)
{
    const std::string job = dependency.queued_before ? dependency.array : "${job[" + dependency.array + "]}";
    if (dependency.corresponding)
        return "aftercorr:" + job;
    if (dependency.elements.empty())
        return "afterok:" + job;
    std::string text = "afterok";
    for (const std::size_t element : dependency.elements)
        text += fmt::format(":{}_{}", job, element);
    return text;
}

/// Of the first arrays that have half of the elements: their end makes room for as many.
std::string continuing_dependency(const Wave& wave)
{
    if (wave.arrays.empty())
        return "afterany:" + wave.follows;
    std::size_t all = 0;
    for (const JobArray& array : wave.arrays)
        all += array.elements.size();
    std::string text = "afterany";
    std::size_t before = 0;
    for (const JobArray& array : wave.arrays)
    {
        text += ":${job[" + array.name + "]}";
        before += array.elements.size();
        if (2 * before >= all)
            break;
    }
    return text;
}

std::optional<std::size_t> number_in(const std::string& text)
{
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

std::string script_problem(const SlurmSettings& settings, const std::filesystem::path& folder)
{
    for (const auto& [name, text] :
         {std::pair("--folder", folder.string()), std::pair("--partition", settings.partition),
          std::pair("--gpu-partition", settings.gpu_partition), std::pair("the path of fresco", settings.program.string())})
        if (std::string problem = script_problem(name, text); !problem.empty())
            return problem;
    return "";
}

std::filesystem::path wave_folder(std::size_t number)
{
    return std::filesystem::path("slurm") / fmt::format("wave-{:03}", number);
}

std::string job_name(const SlurmSettings& settings, std::size_t wave, const std::string& array)
{
    return names_of(settings, wave) + "." + array;
}

std::string array_script(const SlurmSettings& settings, const Wave& wave, const JobArray& array)
{
    const bool on_gpu = array.limits.gpu && !settings.gpu_partition.empty();
    const std::filesystem::path folder = wave.folder / wave_folder(wave.number);
    return head(settings, wave, array.name, on_gpu ? settings.gpu_partition : settings.partition) +
           fmt::format(R"~(#SBATCH --array={ranges}
#SBATCH --cpus-per-task={threads} --mem={memory}M{gpu}
#SBATCH --time={minutes}
#SBATCH --requeue --open-mode=append --signal=B:TERM@{warning}
#SBATCH --kill-on-invalid-dep=yes
#SBATCH --output={output}

job=${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID
read -r _ task name < <(grep "^$SLURM_ARRAY_TASK_ID " {list})
echo "== task $task ($name), job $job on $(hostname), start $((${{SLURM_RESTART_COUNT:-0}} + 1)), $(date -u +%FT%TZ)"

# A minute before the time limit: fresco writes checkpoints and ends with 75.
stop() {{ trap '' TERM; stopped=yes; kill -TERM $fresco; }}
{program} run --task "$task" --cores {threads} {folder} &
fresco=$!
trap stop TERM
wait $fresco
code=$?
if [ -n "$stopped" ]; then
    wait $fresco
    code=$?
fi

# Interrupted, not canceled: it goes on from its checkpoints.
if [ $code -eq 75 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {requeues} ] && [ "$(squeue --noheader --job=$job --format=%T)" = RUNNING ]; then
    trap - TERM
    scontrol requeue $job && sleep 300 # Slurm ends this script.
fi
exit $code
)~",
                       fmt::arg("ranges", index_ranges(array.elements)), fmt::arg("threads", array.limits.threads),
                       fmt::arg("memory", array.limits.memory_mb), fmt::arg("gpu", array.limits.gpu ? " --gres=gpu:1" : ""),
                       fmt::arg("minutes", array.limits.minutes), fmt::arg("warning", warning_seconds),
                       fmt::arg("output", quoted(literal((folder / (array.name + ".")).string()) + "%a.log")),
                       fmt::arg("list", shell_word((folder / (array.name + ".list")).string())),
                       fmt::arg("program", shell_word(settings.program.string())),
                       fmt::arg("folder", shell_word(wave.folder.string())), fmt::arg("requeues", most_requeues));
}

std::string array_list(const JobArray& array)
{
    std::string text;
    for (const ArrayElement& element : array.elements)
        text += fmt::format("{} {} {}\n", element.index, element.task, element.name);
    return text;
}

std::string continuing_script(const SlurmSettings& settings, const Wave& wave)
{
    return head(settings, wave, continuing_name, settings.partition) +
           fmt::format(R"~(#SBATCH --cpus-per-task=1 --mem=2000M
#SBATCH --time=30
#SBATCH --requeue --open-mode=append
#SBATCH --output={}

exec {} submit slurm --continue {}
)~",
                       quoted(literal((wave.folder / wave_folder(wave.number) / continuing_name).string()) + ".log"),
                       shell_word(settings.program.string()), shell_word(wave.folder.string()));
}

std::string submit_script(const SlurmSettings& settings, const Wave& wave)
{
    std::string text = fmt::format(R"~(#!/usr/bin/env bash
# Submits the job arrays of this folder, each after those that it waits for. Interrupted, run it again: no array is submitted twice.
set -euo pipefail
cd "$(dirname "${{BASH_SOURCE[0]}}")"
run={}

# Two submissions at once would queue tasks twice. fresco holds the lock where it runs this script.
if [ -z "${{FRESCO_SUBMITS:-}}" ]; then
    exec 3>>../lock
    flock --nonblock 3 || {{ echo "another submission of this folder is running" >&2; exit 1; }}
fi

declare -A job=() begun=()
touch jobs
while read -r array id; do
    if [ "$id" = submitting ]; then begun[$array]=yes; else job[$array]=$id; fi
done <jobs

# submit ARRAY [DEPENDENCY]: its id into job[ARRAY], and into the file jobs
submit() {{
    [ -z "${{job[$1]:-}}" ] || return 0
    local id=
    # Ended between sbatch and its answer? Then the scheduler knows the name.
    [ -z "${{begun[$1]:-}}" ] || id=$(squeue --noheader --states=all --name="$run.$1" --format=%F | head -n 1)
    if [ -z "$id" ]; then
        echo "$1 submitting" >>jobs
        id=$(sbatch --parsable ${{2:+--dependency="$2"}} "$1.sbatch")
    fi
    job[$1]=${{id%%;*}}
    echo "$1 ${{job[$1]}}" >>jobs
}}

)~",
                                   names_of(settings, wave.number));
    for (const JobArray& array : wave.arrays)
    {
        const std::string dependencies = fmt::format("{}", fmt::join(each(array.dependencies, dependency_text), ","));
        text += "submit " + array.name + (dependencies.empty() ? "" : " \"" + dependencies + "\"") + "\n";
    }

    if (wave.continued)
        text += fmt::format("submit {} \"{}\"\n", continuing_name, continuing_dependency(wave));
    return text;
}

std::string ProgramEnd::quoted_output() const
{
    if (output.find('\n') >= output.find_last_not_of('\n'))
        return " " + output.substr(0, output.find('\n'));
    std::string text;
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);)
        text += "\n    | " + line;
    return text;
}

ProgramEnd run_program(ProcessStart start)
{
    start.file = find_program(start.arguments.front());
    if (start.file.empty())
        throw MissingInput(start.arguments.front() +
                           ": no such program; install Slurm's client commands, or use a machine that has them");
    Process process = start_process(start);
    ProgramEnd result;
    LineBuffer lines;
    std::string line;
    for (bool open = true; open;)
    {
        pollfd readable{process.output.get(), POLLIN, 0};
        poll(&readable, 1, -1);
        open = lines.read_from(process.output.get());
        while (lines.next(line))
            result.output += line + "\n";
    }
    result.output += lines.rest();
    ProcessEnd end;
    while (!take_end(process.pid, end))
        poll(nullptr, 0, 1);
    result.exit_code = end.exit_code;
    return result;
}

std::string slurm_answer(const std::vector<std::string>& words)
{
    const ProgramEnd end = run_program({.file = {}, .arguments = words});
    if (end.exit_code != 0)
        throw Error(words.front() + " failed:" + end.quoted_output());
    return end.output;
}

SlurmLimits limits_in(const std::string& config)
{
    SlurmLimits limits;
    std::istringstream lines(config);
    for (std::string line; std::getline(lines, line);)
    {
        std::istringstream words(line);
        std::string name, equals, value;
        words >> name >> equals >> value;
        if (const auto number = number_in(value); number && *number > 0)
        {
            if (name == "MaxArraySize")
                limits.array_size = *number;
            else if (name == "MaxJobCount")
                limits.job_count = *number;
        }
    }
    return limits;
}

SlurmLimits slurm_limits()
{
    return limits_in(slurm_answer({"scontrol", "show", "config"}));
}

SlurmQueue queue_in(const std::string& lines, const std::string& run)
{
    SlurmQueue queue;
    std::istringstream text(lines);
    for (std::string line; std::getline(text, line);)
    {
        std::istringstream words(line);
        std::string id, index, state, name;
        if (!(words >> id >> index >> state >> name) || !name.starts_with(run + "."))
            continue;
        queue.jobs[name] = id;
        if (const auto number = number_in(index))
            queue.elements[{id, *number}] = state;
    }
    return queue;
}

SlurmQueue slurm_queue(const std::string& run)
{
    return queue_in(
        slurm_answer({"squeue", "--noheader", "--array", "--user=" + std::to_string(getuid()), "--format=%F %K %T %j"}), run);
}

}  // namespace fresco::host
