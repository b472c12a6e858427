#pragma once

#include <compare>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

/// \file Tasks as job arrays of a batch scheduler: few submissions, and one failed task blocks only those that need it.

namespace fresco::host
{

/// What a task is given.
struct JobLimits
{
    int minutes = 0;    ///< Time limit.
    int memory_mb = 0;  ///< Memory limit.
    int threads = 1;
    bool gpu = false;

    friend auto operator<=>(const JobLimits&, const JobLimits&) = default;
};

/// A task to be queued.
struct QueuedTask
{
    std::size_t number = 0;          ///< In the task table.
    std::string group;               ///< Tasks of a group have the same axes and the same kind of resources.
    std::string name;                ///< "stage@value,value": that of its log.
    std::vector<std::size_t> needs;  ///< Numbers of the tasks that must end before it.
    JobLimits limits;
};

/// Where a task is: an element of an array of this submission ("texture-0"), or of a job that is in the queue already (its id).
struct ElementPlace
{
    std::string array;
    std::size_t index = 0;
    bool queued_before = false;  ///< `array` is the id of a job.

    friend bool operator==(const ElementPlace&, const ElementPlace&) = default;
};

/// What an array waits for. Without `corresponding`, all of its elements wait for the same `elements` (empty: for the whole
/// array); with it, each waits for the element of the same index.
struct ArrayDependency
{
    std::string array;
    bool queued_before = false;
    bool corresponding = false;
    std::vector<std::size_t> elements;
};

struct ArrayElement
{
    std::size_t index = 0;
    std::size_t task = 0;
    std::string name;
};

struct JobArray
{
    std::string name;                    ///< "stage-0"
    std::vector<ArrayElement> elements;  ///< By index.
    std::vector<ArrayDependency> dependencies;
    JobLimits limits;
};

/// The arrays that queue `tasks`, each after those that it waits for. `tasks`: each after those that it needs. A need that is
/// neither among them nor in `queued` is taken to be done. `largest`: one more than the largest index that the scheduler allows.
std::vector<JobArray> job_arrays(const std::vector<QueuedTask>& tasks, const std::map<std::size_t, ElementPlace>& queued,
                                 std::size_t largest);

/// Indices as sbatch reads them: "0-3,7".
std::string index_ranges(const std::vector<ArrayElement>& elements);

}  // namespace fresco::host
