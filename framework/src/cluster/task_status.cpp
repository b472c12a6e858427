#include "cluster/task_status.h"
#include "base/records.h"
#include "base/unit_text.h"
#include <fresco/error.h>

#include <algorithm>
#include <fmt/format.h>
#include <map>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

fs::path end_file(const fs::path& folder, std::size_t task)
{
    return folder / "ended" / fmt::format("{:06}.json", task);
}

/// Of a task that is neither done nor in the queue.
void explain(TaskStatus& status, const fs::path& folder, std::size_t task)
{
    if (auto end = read_task_end(folder, task); end && !end->failed.empty())
    {
        status.state = TaskState::failed;
        status.failed = std::move(end->failed);
        return;
    }
    const TaskLog log = last_log(folder, status.name);
    if (status.job.empty() || log.job != status.job)
        return;
    status.state = TaskState::failed;
    status.error = log.memory_ran_out() ? "its job ran out of memory"
                   : log.time_ran_out() ? "its job reached its time limit"
                                        : "its job ended before the task; the end of its log may tell why";
}

}  // namespace

void write_task_end(const fs::path& folder, std::size_t task, const RunSummary& summary)
{
    Value::List failed;
    for (const StageOutcome& stage : summary.stages)
        if (stage.state == StageState::failed)
            failed.push_back(Value::Map{{"stage", stage.stage}, {"error", stage.error}});
    make_folder(folder / "ended");
    write_record(end_file(folder, task), Value::Map{{"exit_code", summary.exit_code}, {"failed", std::move(failed)}});
}

std::optional<TaskEnd> read_task_end(const fs::path& folder, std::size_t task)
{
    if (!is_file(end_file(folder, task)))
        return std::nullopt;
    const Value record = read_record(end_file(folder, task));
    TaskEnd end{static_cast<int>(record.at("exit_code").as_int()), {}};
    for (const Value& stage : record.at("failed").as_list())
        end.failed.push_back({stage.at("stage").as_string(), stage.at("error").as_string()});
    return end;
}

void remove_task_end(const fs::path& folder, std::size_t task)
{
    remove_quietly(end_file(folder, task));
}

std::string_view to_string(TaskState state)
{
    switch (state)
    {
    case TaskState::done:
        return "done";
    case TaskState::running:
        return "running";
    case TaskState::queued:
        return "queued";
    case TaskState::failed:
        return "failed";
    case TaskState::not_run:
        return "not run";
    }
    return "";
}

std::vector<TaskStatus> task_status(const TaskTable& table, const TaskKnowledge& known, const fs::path& folder)
{
    std::vector<TaskStatus> result;
    for (const Task& task : table.tasks)
    {
        TaskStatus status;
        status.name = task_name(table, task);
        status.log = folder / "logs" / (status.name + ".log");
        const auto attempts = known.attempts.find(task.id);
        const Attempt* attempt = known.in_queue(task.id);
        if (attempt == nullptr && attempts != known.attempts.end())
            attempt = &attempts->second.back();
        if (attempt != nullptr)
            status.job = attempt->element.first + "_" + std::to_string(attempt->element.second);
        if (known.done[task.id])
            status.state = TaskState::done;
        else if (const Attempt* queued = known.in_queue(task.id))
            status.state = known.queue.elements.at(queued->element) == "PENDING" ? TaskState::queued : TaskState::running;
        else
            explain(status, folder, task.id);
        result.push_back(std::move(status));
    }
    return result;
}

std::vector<bool> done_tasks(const TaskTable& table, const std::vector<StageNode>& stages)
{
    std::map<std::string, StageState> states;
    for (const StageNode& node : stages)
        states[node.stage->name] = node.state;
    std::vector<bool> done;
    for (const Task& task : table.tasks)
        done.push_back(std::all_of(task.stages.begin(), task.stages.end(),
                                   [&](const std::string& stage)
                                   {
                                       const StageState state = states.at(stage);
                                       return state == StageState::stored || state == StageState::not_needed;
                                   }));
    return done;
}

RunSummary summary_of(const std::vector<StageNode>& stages, const std::vector<TaskStatus>& tasks)
{
    RunSummary summary;
    for (const StageNode& node : stages)
    {
        if (node.state == StageState::not_selected)
            continue;
        StageOutcome outcome{node.stage->name, node.stage->type->type, node.state, node.key, "", 0, 0, 0, 0, node.error};
        if (node.state == StageState::waiting)
            outcome.state = StageState::blocked;
        if (node.present && node.result)
            outcome.object = node.result->object;
        summary.stages.push_back(std::move(outcome));
    }
    mark_failed(summary, tasks);
    return summary;
}

void mark_failed(RunSummary& summary, const std::vector<TaskStatus>& tasks)
{
    std::map<std::string, std::string> errors;
    for (const TaskStatus& task : tasks)
        for (const FailedStage& failed : task.failed)
            errors[failed.stage] = failed.error;
    for (StageOutcome& stage : summary.stages)
        if (const auto error = errors.find(stage.stage); error != errors.end() && stage.state == StageState::blocked)
        {
            stage.state = StageState::failed;
            stage.error = error->second;
        }
}

}  // namespace fresco::host
