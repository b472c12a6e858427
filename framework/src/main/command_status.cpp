#include "base/common.h"
#include "base/machine.h"
#include "base/text.h"
#include "cluster/submit.h"
#include "display/display.h"
#include "main/commands.h"
#include "report/report.h"
#include "run/sweep.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct FolderArguments
{
    std::string folder;
    bool json = false;
    std::vector<std::string> words;

    fs::path path() const { return guarded_task_folder(folder); }
};

/// Of a combination with stages that have not run: what their tasks wait for.
void show_queue(std::vector<CombinationOutcome>& outcomes, const Pipeline& pipeline, const TaskFolder& tasks)
{
    std::map<std::string, TaskState> states;
    for (const Task& task : tasks.table.tasks)
        for (const std::string& stage : task.stages)
            states[stage] = tasks.status[task.id].state;
    for (CombinationOutcome& outcome : outcomes)
    {
        if (outcome.state != "not run")
            continue;
        std::set<TaskState> found;
        for (const std::size_t stage : outcome.combination->stages)
            if (const auto state = states.find(pipeline.stages[stage].name); state != states.end())
                found.insert(state->second);
        // A task that could not say which of its stages it was at.
        for (const TaskState state : {TaskState::running, TaskState::queued, TaskState::failed})
            if (found.contains(state))
            {
                outcome.state = to_string(state);
                break;
            }
    }
}

void print_json(const TaskFolder& tasks, const std::vector<CombinationOutcome>& outcomes, const RunSummary& summary,
                const Pipeline& pipeline)
{
    const auto told = [&](const CombinationOutcome& outcome) { return combination_data(pipeline.sweep, summary, outcome); };
    Value::List list;
    for (const Task& task : tasks.table.tasks)
    {
        const TaskStatus& status = tasks.status[task.id];
        list.push_back(Value::Map{{"id", task.id},
                                  {"name", status.name},
                                  {"state", to_string(status.state)},
                                  {"job", status.job},
                                  {"log", status.log.string()},
                                  {"error", status.failed.empty() ? status.error : status.failed.front().error}});
    }
    print_value(Value::Map{{"store", tasks.table.store.string()},
                           {"out", tasks.table.out.string()},
                           {"combinations", each<Value>(outcomes, told)},
                           {"tasks", std::move(list)}});
}

/// Why, and where to read more; not more than a screen of it.
void print_failures(const TaskFolder& tasks)
{
    constexpr std::size_t most_shown = 10;
    std::size_t count = 0;
    for (const TaskStatus& status : tasks.status)
        if (status.state == TaskState::failed && ++count <= most_shown)
        {
            for (const FailedStage& failed : status.failed)
                fmt::print("{}\n", folded(harmless(failed.error, LineEnds::continued), terminal_width(STDOUT_FILENO), 2));
            if (status.failed.empty())
                print_line(status.name + ": " + status.error);
            if (fs::exists(status.log))
                print_line("    " + path_text(status.log));
        }
    if (count > most_shown)
        fmt::print("… and {} more failed tasks\n", count - most_shown);
}

void print_counts(const TaskFolder& tasks)
{
    std::map<TaskState, std::size_t> counts;
    for (const TaskStatus& status : tasks.status)
        ++counts[status.state];
    std::string text;
    for (const auto& [state, count] : counts)
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, to_string(state));
    fmt::print("{}: {}\n", counted(tasks.status.size(), "task"), text);
}

int status(const FolderArguments& arguments)
{
    const auto loaded = load_tasks(arguments.path());
    if (!loaded->result.problems.empty())
        return loaded->result.exit_code();
    const Pipeline& pipeline = loaded->result.pipeline;
    const TaskFolder tasks = look_at_tasks(arguments.path(), pipeline);
    const RunSummary summary = summary_of(tasks.stages, tasks.status);
    auto outcomes = combination_outcomes(pipeline, summary, Store(tasks.table.store));
    show_queue(outcomes, pipeline, tasks);
    if (arguments.json)
    {
        print_json(tasks, outcomes, summary, pipeline);
        return 0;
    }
    if (!outcomes.empty())
        fmt::print("{}", sweep_table(pipeline.sweep, outcomes, terminal_width(STDOUT_FILENO)));
    print_counts(tasks);
    print_failures(tasks);
    return 0;
}

int cancel(const FolderArguments& arguments)
{
    const std::size_t jobs = cancel_jobs(arguments.path());
    fmt::print("{}\n", jobs == 0 ? "none of its jobs is in the queue"
                                 : fmt::format("canceled {}; `fresco submit slurm {}` queues what is missing",
                                               counted(jobs, "job"), shell_word(path_text(arguments.path()))));
    return 0;
}

int collect(const FolderArguments& arguments)
{
    const auto loaded = load_tasks(arguments.path());
    if (!loaded->result.problems.empty())
        return loaded->result.exit_code();
    const TaskFolder tasks = look_at_tasks(arguments.path(), loaded->result.pipeline);
    RunRequest request;
    request.pipeline = &loaded->result.pipeline;
    request.store = tasks.table.store;
    request.out = tasks.table.out;
    request.cores = available_cores();
    request.until = tasks.table.pipeline.until;
    request.only_stored = true;
    RunSummary summary;
    {
        const auto display = make_display(DisplayKind::quiet);
        summary = run_pipeline(request, *display);
    }
    mark_failed(summary, tasks.status);
    // As `fresco run` ends where stages failed, and where it was interrupted.
    const auto in_state = [&](StageState state)
    { return std::ranges::any_of(summary.stages, [&](const auto& stage) { return stage.state == state; }); };
    summary.exit_code = in_state(StageState::failed) ? 1 : in_state(StageState::blocked) ? 75 : summary.exit_code;
    const ReportRequest ended{&request, &summary, &loaded->catalog, arguments.words, 0, false};
    for (const ReportOutcome& report : write_reports(ended))
        if (!report.note.empty())
            print_message(report.note);
    if (!request.pipeline->sweep.axes.empty())
        tell_combinations(ended, "", true);
    print_counts(tasks);
    return summary.exit_code;
}

}  // namespace

void add_task_commands(CLI::App& app, const std::vector<std::string>& words, int& exit_code)
{
    const auto add = [&](const char* name, const char* help, int (*command)(const FolderArguments&))
    {
        CLI::App* added = app.add_subcommand(name, help);
        const auto arguments = std::make_shared<FolderArguments>();
        arguments->words = words;
        added->add_option("folder", arguments->folder, "Folder of tasks, as `fresco submit` writes it")->required();
        added->callback([arguments, command, &exit_code] { exit_code = command(*arguments); });
        return std::pair(added, arguments);
    };
    const auto [shown, arguments] = add("status", "Show what became of submitted tasks", status);
    shown->add_flag("--json", arguments->json, "Print JSON");
    add("cancel", "Take the jobs of submitted tasks out of the queue", cancel);
    add("collect", "Write the results of submitted tasks, with sweep.json and the reports", collect);
}

}  // namespace fresco::host
