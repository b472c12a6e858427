#pragma once

#include "cluster/submission.h"
#include "pipeline/pipeline.h"
#include "run/scheduler.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file What became of the tasks of a submission, and which of them to queue next. `fresco submit`, `status`, `cancel` and
/// `collect` use it.

namespace fresco::host
{

/// What is known about the tasks of a table before some of them are queued.
struct TaskKnowledge
{
    std::vector<bool> done;  ///< By task: its results are in the store.
    std::map<std::size_t, std::vector<Attempt>> attempts;
    SlurmQueue queue;

    /// Where a task is in the queue; nullptr: it is not.
    const Attempt* in_queue(std::size_t task) const;
};

struct MissingTasks
{
    std::vector<QueuedTask> tasks;               ///< To be queued now, each after those that it needs.
    std::map<std::size_t, ElementPlace> queued;  ///< In the queue already.
    std::size_t left = 0;                        ///< For when there is room in the queue.
    std::size_t blocked = 0;                     ///< Need a task that failed.
};

/// Time and memory limits of a task: twice and 1.3 times what its group is estimated to take, and twice those of its last attempt
/// where these were not enough.
JobLimits limits_of(const TaskGroup& group, const Attempt* last, const TaskLog& log);

/// The tasks that are neither done nor in the queue, as many as `room` allows. `round`: tasks that were attempted in it are left
/// out, and so is what needs them; a round that was not begun leaves out none.
MissingTasks missing_tasks(const TaskTable& table, const TaskKnowledge& known, const std::filesystem::path& folder,
                           std::size_t round, std::size_t room);

/// A stage of a task that failed.
struct FailedStage
{
    std::string stage;
    std::string error;
};

/// Writes what the process of a task came to, as it says itself, into ended/000017.json below the folder of tasks: {exit_code,
/// failed: [{stage, error}]}. Throws Error if the file cannot be written.
void write_task_end(const std::filesystem::path& folder, std::size_t task, const RunSummary& summary);
/// Called when a task begins.
void remove_task_end(const std::filesystem::path& folder, std::size_t task);

/// In the order of what to_string calls them.
enum class TaskState
{
    done,
    running,
    queued,
    failed,
    not_run
};
std::string_view to_string(TaskState state);

struct TaskStatus
{
    TaskState state = TaskState::not_run;
    std::string name;
    std::string job;  ///< "123_4", of the last attempt; empty: never submitted.
    std::filesystem::path log;
    std::vector<FailedStage> failed;
    std::string error;  ///< Of a failed task that could not say why itself.
};

/// The stages of a pipeline as a run would tell them that found them so.
RunSummary summary_of(const std::vector<StageNode>& stages, const std::vector<TaskStatus>& tasks);
/// Stages that were not run and of which a task says that they failed count as failed.
void mark_failed(RunSummary& summary, const std::vector<TaskStatus>& tasks);

/// A folder of tasks as it stands: the scheduler is asked first, so that what it lists as ended is looked for in the store.
struct TaskFolder
{
    TaskTable table;
    std::vector<StageNode> stages;
    TaskKnowledge known;
    std::vector<TaskStatus> status;
};
/// `pipeline`: the table's, and must outlive the result. Where nothing was submitted, or there is no Slurm any more, the queue is
/// taken to be empty. Throws Error if the scheduler does not answer.
TaskFolder look_at_tasks(const std::filesystem::path& folder, const Pipeline& pipeline);

struct SubmitRequest
{
    std::filesystem::path folder;
    bool dry_run = false;    ///< Writes the files and submits nothing.
    bool continued = false;  ///< By the job at the end of a wave: what is left of its round.
};

struct SubmitOutcome
{
    Wave wave;             ///< Without arrays where nothing had to be submitted.
    MissingTasks missing;  ///< `tasks` are those in the wave.
    std::size_t done = 0;
    std::string silence;  ///< Why Slurm did not answer a dry run, which then takes its queue to be empty; or empty.
    ProgramEnd script;    ///< Of submit.sh.
};

/// Queues the tasks of a folder that are neither done nor in the queue. Throws Error if another submission of it is running, or
/// the scheduler does not answer (a dry run goes on without it).
SubmitOutcome submit_missing(const SubmitRequest& request, const Pipeline& pipeline);

/// Takes all jobs of a folder out of the queue; how many arrays and other jobs that were.
std::size_t cancel_jobs(const std::filesystem::path& folder);

}  // namespace fresco::host
