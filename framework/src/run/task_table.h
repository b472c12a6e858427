#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/statistics.h"
#include <fresco/value.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// \file What is left to do of a pipeline, cut into tasks that a cluster's scheduler can start in any order that keeps `needs`.
///
/// In a folder (all of it UTF-8 JSON unless said otherwise):
///   pipeline/         the pipeline file and its bases as they were, so that later edits change no task
///   tasks.json        the head, written last:
///     {"version": 1, "fresco": "0.1.0",
///      "pipeline": {"file": "/home/me/many.yaml", "working_directory": "/home/me", "until": "",
///                   "preview": false,
///                   "files": [{"file": "/home/me/many.yaml", "copy": "pipeline/0-many.yaml", "hash": "…"}],
///                   "sets": [{"name": "texture.device", "value": "cuda"}], "without": ["video"]},
///      "plugins": {"mesh.decimate": {"library": "/usr/lib/fresco/mesh_decimate.so", "hash": "…"}},
///      "store": "/data/store", "out": "/data/out",
///      "axes": [{"name": "data", "labels": ["kitchen", "office"]}], "stage_axes": {"scan": ["data"], "mesh": ["data"]},
///      "groups": [{"name": "data", "axes": ["data"], "gpu": false, "stages": ["scan", "mesh"], "needs": [],
///                  "first": 0, "count": 2, "seconds": 1800, "memory_mb": 900, "threads": 8}],
///      "task_count": 2, "chunk_size": 100}
///   tasks/000000.json tasks 0 … chunk_size - 1, tasks/000001.json the next, …:
///     {"tasks": [{"id": 0, "group": 0, "axes": {"data": "kitchen"}, "stages": ["scan@kitchen", "mesh@kitchen"], "needs": [],
///                 "seconds": 1800, "memory_mb": 900}]}
/// `fresco plan --tasks` prints the head with the tasks as one more entry, "tasks".

namespace fresco::host
{

/// Stages that one process runs, one combination after the other.
struct Task
{
    std::size_t id = 0;  ///< Its place in the table. What a task needs has smaller ids.
    std::size_t group = 0;
    std::vector<std::string> stages;                        ///< As `fresco run` names them, in an order they can run in.
    std::vector<std::pair<std::string, std::string>> axes;  ///< Axis and label, of those that all of its stages share.
    std::vector<std::size_t> needs;                         ///< Tasks that make what its stages read directly; ascending.
    double seconds = 0;                                     ///< Of all its stages together.
    double memory_mb = 0;                                   ///< Of the largest of its stages.
};

/// The tasks of stages that depend on the same axes and run on the same kind of machine: one array of jobs.
struct TaskGroup
{
    std::string name;                 ///< "data", "data,picture", "data,picture-gpu"; "once" without an axis. Fits a file name.
    std::vector<std::string> axes;    ///< In the matrix's order.
    bool gpu = false;                 ///< Its stages run on a GPU.
    std::vector<std::string> stages;  ///< Their own names in the file.
    std::vector<std::size_t> needs;   ///< Groups that some of its tasks need; all smaller than its own number.
    std::size_t first = 0;            ///< Its tasks are first … first + count - 1. A group without tasks isn't in the table.
    std::size_t count = 0;
    double seconds = 0;    ///< Of its longest task.
    double memory_mb = 0;  ///< Of its largest task.
    int threads = 1;       ///< Cores that the estimates assume for each of its tasks.
};

struct FrozenPlugin
{
    std::filesystem::path library;
    std::string hash;  ///< TypeDescription::library_hash.
};

struct TaskAxis
{
    std::string name;
    std::vector<std::string> labels;  ///< Of the chosen values, in the file's order.
};

struct TaskTable
{
    PipelineRequest pipeline;                     ///< As the files were; `sets` say, too, what `auto` devices stand for.
    std::map<std::string, FrozenPlugin> plugins;  ///< By type: of all stages and components.
    std::filesystem::path store;                  ///< Absolute, as is `out`.
    std::filesystem::path out;
    std::vector<TaskAxis> axes;
    std::map<std::string, std::vector<std::string>> stage_axes;  ///< As Sweep has them, of all stages.
    std::vector<TaskGroup> groups;
    std::size_t task_count = 0;
    std::size_t chunk_size = 100;  ///< Tasks in a file.
    std::vector<Task> tasks;       ///< All of them, or none where only the head was read.
};

struct TaskSettings
{
    double pack_seconds = 45 * 60;  ///< Combinations are put into one task up to this time; 0: each is a task.
    int threads = 1;                ///< What `estimates` were made for.
};

/// Cuts the stages that `runs` names (by their places in the pipeline) into groups and tasks. `estimates`: by stage. Fills
/// `axes`, `stage_axes`, `groups`, `task_count` and `tasks` of the result.
///
/// A group's combinations are packed in their order, so that neighbors have the same value of the leading axis. A task ends
/// where that value changes, unless the next value needs the same tasks and all of its combinations fit in: no scan waits for the
/// preparation of another that it would not have to wait for anyway.
TaskTable make_task_table(const Pipeline& pipeline, const std::vector<bool>& runs,
                          const std::map<std::string, CostFigures>& estimates, const TaskSettings& settings);

/// The table of what is left to do of a pipeline that was loaded by `request`: stages whose results are in the store are left
/// out. Throws MissingInput where an input is gone, Error if the store cannot be used.
TaskTable plan_tasks(const PipelineRequest& request, const Pipeline& pipeline, const std::filesystem::path& store,
                     const std::filesystem::path& out, const TaskSettings& settings);

/// Head and tasks as printed by `fresco plan --tasks`.
Value to_value(const TaskTable& table);
/// Writes the folder. Throws Error if there is a table in it, or a file cannot be written.
void write_task_table(const TaskTable& table, const std::filesystem::path& folder);

/// The head, without tasks. Throws MissingInput where the folder has no table, and Error naming file and entry where something
/// in it is missing, of another type or out of range, or a copy of a pipeline file was edited.
TaskTable read_task_head(const std::filesystem::path& folder);
/// One task; reads only its chunk. Throws as above, and where the table has no such task.
Task read_task(const std::filesystem::path& folder, const TaskTable& head, std::size_t id);
/// Head and all tasks.
TaskTable read_task_table(const std::filesystem::path& folder);

/// Loads no more of the pipeline than the combinations that the task is of.
PipelineRequest task_request(const TaskTable& head, const Task& task);

/// What is wrong with the plugins that `pipeline` uses: one whose bytes are not those that the table was made with. Empty:
/// nothing.
std::string changed_plugin(const TaskTable& head, const Pipeline& pipeline);

/// The task's stages. Where another's result is missing, the text names the task that makes it. `folder` has the table; `head`
/// must outlive the result.
RunPart task_part(const std::filesystem::path& folder, const TaskTable& head, const Task& task);

}  // namespace fresco::host
