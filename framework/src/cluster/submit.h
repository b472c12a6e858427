#pragma once

#include "cluster/task_status.h"
#include "pipeline/pipeline.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace fresco::host
{

/// The stages of a table's pipeline as they stand in the store. Remembers file stamps.
std::vector<StageNode> stages_in_store(const TaskTable& head, const Pipeline& pipeline);

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
    Wave wave;              ///< Without arrays where nothing had to be submitted.
    std::size_t tasks = 0;  ///< In it.
    std::size_t done = 0;
    std::size_t queued = 0;   ///< In the queue before.
    std::size_t left = 0;     ///< For a later wave.
    std::size_t blocked = 0;  ///< Failed in this round, or need what failed.
    std::string silence;      ///< Why Slurm did not answer a dry run, which then takes its queue to be empty; or empty.
    ProgramEnd script;        ///< Of submit.sh.
};

/// Queues the tasks of a folder that are neither done nor in the queue. Throws Error if another submission of it is running, or
/// the scheduler does not answer (a dry run goes on without it).
SubmitOutcome submit_missing(const SubmitRequest& request, const Pipeline& pipeline);

/// Takes all jobs of a folder out of the queue; how many arrays and other jobs that were.
std::size_t cancel_jobs(const std::filesystem::path& folder);

}  // namespace fresco::host
