#include "cluster/slurm_queue.h"
#include <fresco/error.h>

#include <charconv>
#include <poll.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

namespace fresco::host
{
namespace
{

std::string answer(const std::vector<std::string>& words)
{
    const ProgramEnd end = run_program({words});
    if (end.exit_code != 0)
        throw Error(words.front() + " failed:" + end.quoted_output());
    return end.output;
}

std::optional<std::size_t> number_in(const std::string& text)
{
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

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

ProgramEnd run_program(const ProgramStart& start)
{
    const std::string file = find_program(start.words.front());
    if (file.empty())
        throw MissingInput(start.words.front() +
                           ": no such program; install Slurm's client commands, or use a machine that has them");
    Process process = start_process({file, start.words, start.environment, start.folder, start.channel});
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

SlurmLimits limits_in(const std::string& config)
{
    SlurmLimits limits;
    std::istringstream lines(config);
    for (std::string line; std::getline(lines, line);)
    {
        std::istringstream words(line);
        std::string name;
        std::string equals;
        std::string value;
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
    return limits_in(answer({"scontrol", "show", "config"}));
}

SlurmQueue queue_in(const std::string& lines, const std::string& run)
{
    SlurmQueue queue;
    std::istringstream text(lines);
    for (std::string line; std::getline(text, line);)
    {
        std::istringstream words(line);
        std::string id;
        std::string index;
        std::string state;
        std::string name;
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
    return queue_in(answer({"squeue", "--noheader", "--array", "--user=" + std::to_string(getuid()), "--format=%F %K %T %j"}),
                    run);
}

}  // namespace fresco::host
