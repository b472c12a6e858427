#include "cluster/submit.h"
#include "base/common.h"
#include "base/file_lock.h"
#include "base/records.h"
#include "run/run_state.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace fresco::host
{

namespace
{

constexpr double time_factor = 2;
constexpr double memory_factor = 1.3;
/// Starting a process on a busy file server takes its time too.
constexpr int least_minutes = 5;
constexpr int least_memory_mb = 500;

/// Slurm takes a ',' in a job's name for the end of it.
std::string array_group(const std::string& group)
{
    std::string text = group;
    std::ranges::replace(text, ',', '+');
    return text;
}

fs::path end_file(const fs::path& folder, std::size_t task)
{
    return folder / "ended" / fmt::format("{:06}.json", task);
}

/// Of a task that is neither done nor in the queue.
void explain(TaskStatus& status, const fs::path& folder, std::size_t task)
{
    // Nothing where the task never ended by itself, or is at work again.
    const Value end = is_file(end_file(folder, task)) ? read_record(end_file(folder, task)) : Value();
    if (!end.is_null())
        for (const Value& stage : end.at("failed").as_list())
            status.failed.push_back({stage.at("stage").as_string(), stage.at("error").as_string()});
    if (!status.failed.empty())
    {
        status.state = TaskState::failed;
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

/// Everybody who submits from a folder holds it: the programs that do so inherit its descriptor.
FileLock submission_lock(const fs::path& folder, bool wait)
{
    FileLock lock(folder / "slurm" / "lock");
    if (!lock.try_exclusive_for(std::chrono::minutes(wait ? 5 : 0)))
        throw Error(folder.string() + ": another submission of this folder is running");
    return lock;
}

/// What Slurm says when a submission is prepared.
struct Scheduler
{
    SlurmLimits limits;
    SlurmQueue queue;
    std::string silence;  ///< Why it did not answer; then the limits are its defaults and the queue is empty.
};

/// A dry run needs no answer: its files are often written on a machine without Slurm.
Scheduler ask_scheduler(const std::string& run, bool dry_run)
{
    try
    {
        return {slurm_limits(), slurm_queue(run), ""};
    }
    catch (const Error& error)
    {
        if (!dry_run)
            throw;
        return {{}, {}, error.what()};
    }
}

/// One for each task of the table.
std::vector<TaskStatus> task_status(const TaskTable& table, const TaskKnowledge& known, const fs::path& folder)
{
    std::vector<TaskStatus> result;
    for (const Task& task : table.tasks)
    {
        TaskStatus status;
        status.name = task_name(table, task);
        status.log = folder / "logs" / (status.name + ".log");
        const auto attempts = known.attempts.find(task.id);
        const Attempt* queued = known.in_queue(task.id);
        if (attempts != known.attempts.end())
        {
            const ElementId& element = (queued ? *queued : attempts->second.back()).element;
            status.job = element.first + "_" + std::to_string(element.second);
        }
        if (known.done[task.id])
            status.state = TaskState::done;
        else if (queued)
            status.state = known.queue.elements.at(queued->element) == "PENDING" ? TaskState::queued : TaskState::running;
        else
            explain(status, folder, task.id);
        result.push_back(std::move(status));
    }
    return result;
}

/// Which tasks have all their results in the store, by the states of the pipeline's stages there.
std::vector<bool> done_tasks(const TaskTable& table, const std::vector<StageNode>& stages)
{
    std::map<std::string, StageState> states;
    for (const StageNode& node : stages)
        states[node.stage->name] = node.state;
    std::vector<bool> done;
    for (const Task& task : table.tasks)
        done.push_back(std::ranges::all_of(task.stages,
                                           [&](const std::string& stage)
                                           {
                                               const StageState state = states.at(stage);
                                               return state == StageState::stored || state == StageState::not_needed;
                                           }));
    return done;
}

/// The stages of a table's pipeline as they stand in the store. Remembers file stamps.
std::vector<StageNode> stages_in_store(const TaskTable& head, const Pipeline& pipeline)
{
    const Store store(head.store);
    set_input_roots(pipeline.inputs);
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, head.pipeline.until);
    state.update();
    hashes.save();
    return state.nodes();
}

}  // namespace

const Attempt* TaskKnowledge::in_queue(std::size_t task) const
{
    const auto found = attempts.find(task);
    if (found == attempts.end())
        return nullptr;
    for (const Attempt& attempt : found->second)
        if (queue.elements.contains(attempt.element))
            return &attempt;
    return nullptr;
}

JobLimits limits_of(const TaskGroup& group, const Attempt* last, const TaskLog& log)
{
    const int minutes = std::max(least_minutes, static_cast<int>(std::ceil(time_factor * group.seconds / 60)));
    const int memory_mb = std::max(least_memory_mb, static_cast<int>(std::ceil(memory_factor * group.memory_mb)));
    const JobLimits tried = last == nullptr ? JobLimits{} : last->limits;
    return {std::max(minutes, tried.minutes * (log.time_ran_out() ? 2 : 1)),
            std::max(memory_mb, tried.memory_mb * (log.memory_ran_out() ? 2 : 1)), group.threads, group.gpu};
}

MissingTasks missing_tasks(const TaskTable& table, const TaskKnowledge& known, const std::filesystem::path& folder,
                           std::size_t round, std::size_t room)
{
    MissingTasks result;
    enum class Fate
    {
        settled,  ///< Done, in the queue, or to be queued.
        left,
        blocked
    };
    std::vector<Fate> fates(table.tasks.size(), Fate::settled);
    for (const Task& task : table.tasks)
    {
        if (known.done[task.id])
            continue;
        if (const Attempt* attempt = known.in_queue(task.id))
        {
            result.queued[task.id] = {attempt->element.first, attempt->element.second, true};
            continue;
        }
        const auto attempts = known.attempts.find(task.id);
        const Attempt* last = attempts == known.attempts.end() ? nullptr : &attempts->second.back();
        const auto any_need = [&](Fate fate)
        { return std::ranges::any_of(task.needs, [&](std::size_t need) { return fates[need] == fate; }); };
        if ((last != nullptr && last->round == round) || any_need(Fate::blocked))
        {
            fates[task.id] = Fate::blocked;
            ++result.blocked;
            continue;
        }
        if (result.tasks.size() >= room || any_need(Fate::left))
        {
            fates[task.id] = Fate::left;
            ++result.left;
            continue;
        }
        const TaskGroup& group = table.groups[task.group];
        std::string name = task_name(table, task);
        const TaskLog log = last == nullptr ? TaskLog{} : last_log(folder, name);
        result.tasks.push_back({task.id, array_group(group.name), std::move(name), task.needs, limits_of(group, last, log)});
    }
    return result;
}

void write_task_end(const fs::path& folder, std::size_t task, const RunSummary& summary)
{
    Value::List failed;
    for (const StageOutcome& stage : summary.stages)
        if (stage.state == StageState::failed)
            failed.push_back(Value::Map{{"stage", stage.stage}, {"error", stage.error}});
    make_folder(folder / "ended");
    write_record(end_file(folder, task), Value::Map{{"exit_code", summary.exit_code}, {"failed", std::move(failed)}});
}

void remove_task_end(const fs::path& folder, std::size_t task)
{
    remove_quietly(end_file(folder, task));
}

std::string_view to_string(TaskState state)
{
    constexpr std::array<std::string_view, 5> names{"done", "running", "queued", "failed", "not run"};
    return names.at(static_cast<std::size_t>(state));
}

RunSummary summary_of(const std::vector<StageNode>& stages, const std::vector<TaskStatus>& tasks)
{
    RunSummary summary;
    for (const StageNode& node : stages)
        if (node.state != StageState::not_selected)
            summary.stages.push_back(outcome_of(node));
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

TaskFolder look_at_tasks(const fs::path& folder, const Pipeline& pipeline)
{
    TaskFolder result;
    result.table = read_task_table(folder);
    const auto submission = Submission::is_at(folder) ? std::optional<Submission>(folder) : std::nullopt;
    if (submission && !find_program("squeue").empty())
        result.known.queue = slurm_queue(submission->settings().run);
    result.stages = stages_in_store(result.table, pipeline);
    result.known.done = done_tasks(result.table, result.stages);
    if (submission)
        result.known.attempts = submission->attempts(result.known.queue);
    result.status = task_status(result.table, result.known, folder);
    return result;
}

SubmitOutcome submit_missing(const SubmitRequest& request, const Pipeline& pipeline)
{
    const FileLock lock = submission_lock(request.folder, request.continued);
    Submission submission(request.folder);
    const TaskTable table = read_task_table(request.folder);
    const Scheduler scheduler = ask_scheduler(submission.settings().run, request.dry_run);
    const SlurmLimits& limits = scheduler.limits;
    const TaskKnowledge known{done_tasks(table, stages_in_store(table, pipeline)), submission.attempts(scheduler.queue),
                              scheduler.queue};

    // The job that will continue is one too, and so is this one where it does.
    const std::size_t most = submission.settings().max_queued > 0 ? submission.settings().max_queued : limits.job_count / 2;
    const std::size_t in_queue = known.queue.elements.size() + (request.continued ? 2 : 1);
    const std::size_t round = request.continued ? submission.round() : submission.round() + 1;
    SubmitOutcome outcome;
    outcome.missing = missing_tasks(table, known, request.folder, round, most > in_queue ? most - in_queue : 0);
    const MissingTasks& missing = outcome.missing;
    outcome.silence = scheduler.silence;
    outcome.done = static_cast<std::size_t>(std::ranges::count(known.done, true));
    outcome.wave = {request.folder, submission.next_wave(), job_arrays(missing.tasks, missing.queued, limits.array_size),
                    missing.left > 0, missing.queued.empty() ? "" : missing.queued.begin()->second.array};
    if (missing.tasks.empty() && (missing.left == 0 || missing.queued.empty()))
        return outcome;
    submission.write(outcome.wave, round);
    if (request.dry_run)
        return outcome;
    const fs::path script = request.folder / wave_folder(outcome.wave.number) / "submit.sh";
    outcome.script = run_program({.file = {},
                                  .arguments = {"bash", script.string()},
                                  .environment = {{"FRESCO_SUBMITS", "yes"}},
                                  .channel = lock.descriptor()});
    return outcome;
}

std::size_t cancel_jobs(const fs::path& folder)
{
    const Submission submission(folder);
    const FileLock lock = submission_lock(folder, true);
    std::vector<std::string> words{"scancel"};
    for (const auto& [name, id] : slurm_queue(submission.settings().run).jobs)
        words.push_back(id);
    if (words.size() == 1)
        return 0;
    slurm_answer(words);
    return words.size() - 1;
}

}  // namespace fresco::host
