#include "cluster/submit.h"
#include "base/file_lock.h"
#include "run/run_state.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace fresco::host
{
namespace fs = std::filesystem;
namespace
{

/// Everybody who submits from a folder holds it: the programs that do so inherit its descriptor.
FileLock submission_lock(const fs::path& folder, bool wait)
{
    using namespace std::chrono_literals;
    FileLock lock(folder / "slurm" / "lock");
    const auto end = std::chrono::steady_clock::now() + (wait ? 5min : 0s);
    while (!lock.try_exclusive())
    {
        if (std::chrono::steady_clock::now() >= end)
            throw Error(folder.string() + ": another submission of this folder is running");
        std::this_thread::sleep_for(1s);
    }
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

TaskKnowledge knowledge_of(const Submission& submission, const TaskTable& table, const std::vector<StageNode>& stages,
                           SlurmQueue queue)
{
    auto attempts = submission.attempts(queue);
    return {done_tasks(table, stages), std::move(attempts), std::move(queue)};
}

}  // namespace

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

TaskFolder look_at_tasks(const fs::path& folder, const Pipeline& pipeline)
{
    TaskFolder result;
    result.table = read_task_table(folder);
    if (Submission::is_at(folder))
    {
        const Submission submission(folder);
        SlurmQueue queue = find_program("squeue").empty() ? SlurmQueue{} : slurm_queue(submission.settings().run);
        result.stages = stages_in_store(result.table, pipeline);
        result.known = knowledge_of(submission, result.table, result.stages, std::move(queue));
    }
    else
    {
        result.stages = stages_in_store(result.table, pipeline);
        result.known.done = done_tasks(result.table, result.stages);
    }
    result.status = task_status(result.table, result.known, folder);
    return result;
}

SubmitOutcome submit_missing(const SubmitRequest& request, const Pipeline& pipeline)
{
    const FileLock lock = submission_lock(request.folder, request.continued);
    Submission submission(request.folder);
    const TaskTable table = read_task_table(request.folder);
    Scheduler scheduler = ask_scheduler(submission.settings().run, request.dry_run);
    const SlurmLimits& limits = scheduler.limits;
    const TaskKnowledge known = knowledge_of(submission, table, stages_in_store(table, pipeline), std::move(scheduler.queue));

    // The job that will continue is one too, and so is this one where it does.
    const std::size_t most = submission.settings().max_queued > 0 ? submission.settings().max_queued : limits.job_count / 2;
    const std::size_t in_queue = known.queue.elements.size() + (request.continued ? 2 : 1);
    const std::size_t round = request.continued ? submission.round() : submission.round() + 1;
    const MissingTasks missing = missing_tasks(table, known, request.folder, round, most > in_queue ? most - in_queue : 0);

    SubmitOutcome outcome;
    outcome.silence = scheduler.silence;
    outcome.tasks = missing.tasks.size();
    outcome.done = static_cast<std::size_t>(std::count(known.done.begin(), known.done.end(), true));
    outcome.queued = missing.queued.size();
    outcome.left = missing.left;
    outcome.blocked = missing.blocked;
    outcome.wave = {request.folder, submission.next_wave(), job_arrays(missing.tasks, missing.queued, limits.array_size),
                    missing.left > 0, missing.queued.empty() ? "" : missing.queued.begin()->second.array};
    if (missing.tasks.empty() && (missing.left == 0 || missing.queued.empty()))
        return outcome;
    submission.write(outcome.wave, round);
    if (request.dry_run)
        return outcome;
    const fs::path script = request.folder / wave_folder(outcome.wave.number) / "submit.sh";
    outcome.script = run_program({{"bash", script.string()}, "", {{"FRESCO_SUBMITS", "yes"}}, lock.descriptor()});
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
    if (const ProgramEnd end = run_program({words}); end.exit_code != 0)
        throw Error("scancel failed:" + end.quoted_output());
    return words.size() - 1;
}

}  // namespace fresco::host
