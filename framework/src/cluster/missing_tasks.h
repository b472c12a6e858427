#pragma once

#include "cluster/submission.h"

#include <cstddef>
#include <map>
#include <vector>

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
void set_limits(QueuedTask& task, const TaskGroup& group, const Attempt* last, const TaskLog& log);

/// The tasks that are neither done nor in the queue, as many as `room` allows. `round`: tasks that were attempted in it are left
/// out, and so is what needs them; a round that was not begun leaves out none.
MissingTasks missing_tasks(const TaskTable& table, const TaskKnowledge& known, const std::filesystem::path& folder,
                           std::size_t round, std::size_t room);

}  // namespace fresco::host
