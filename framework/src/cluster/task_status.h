#pragma once

#include "cluster/missing_tasks.h"
#include "run/scheduler.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fresco::host
{

/// A stage of a task that failed.
struct FailedStage
{
    std::string stage;
    std::string error;
};

/// What the process of a task came to, as it says itself; in ended/000017.json below the folder of tasks.
struct TaskEnd
{
    int exit_code = 0;
    std::vector<FailedStage> failed;
};
/// Throws Error if the file cannot be written.
void write_task_end(const std::filesystem::path& folder, std::size_t task, const RunSummary& summary);
/// Nothing where the task never ended by itself, or is at work again.
std::optional<TaskEnd> read_task_end(const std::filesystem::path& folder, std::size_t task);
/// Called when a task begins.
void remove_task_end(const std::filesystem::path& folder, std::size_t task);

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

/// One for each task of the table.
std::vector<TaskStatus> task_status(const TaskTable& table, const TaskKnowledge& known, const std::filesystem::path& folder);

/// Which tasks have all their results in the store, by the states of the pipeline's stages there.
std::vector<bool> done_tasks(const TaskTable& table, const std::vector<StageNode>& stages);

/// The stages of a pipeline as a run would tell them that found them so.
RunSummary summary_of(const std::vector<StageNode>& stages, const std::vector<TaskStatus>& tasks);
/// Stages that were not run and of which a task says that they failed count as failed.
void mark_failed(RunSummary& summary, const std::vector<TaskStatus>& tasks);

}  // namespace fresco::host
