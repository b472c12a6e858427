#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/store.h"
#include <fresco/value.h>

#include <string>
#include <utility>
#include <vector>

/// \file Cuts a pipeline into tasks for an execution engine, such as Snakemake, which starts each one as a process of its own:
/// `fresco run FILE --task NAME`. The tasks follow from the file and `--set` only, so every machine cuts in the same way.

namespace fresco::host
{

/// Stages that depend on the same axes, for one combination of these axes' values.
struct Task
{
    std::string name;                 ///< "once", "data@kitchen", "data,picture-gpu@kitchen,waves".
    std::vector<std::string> stages;  ///< In an order in which they can run.
    std::vector<std::string> needs;   ///< Tasks that make what its stages read directly, sorted.
    bool gpu = false;                 ///< Its stages run on a GPU.
};

/// All tasks, whatever is stored; a task comes after those that it needs. `until`: without stages that this one does not need;
/// empty: all stages.
std::vector<Task> tasks_of(const Pipeline& pipeline, const std::string& until);

/// The stages of the task. Where another task's result is missing, the error names that task. Throws Error with the nearest name
/// if there is no such task.
RunPart task_part(const Pipeline& pipeline, const std::string& until, const std::string& name);

/// Output of `fresco plan --tasks`: {"args": ["--set", …], "tasks": [{name, stages, needs, gpu, done, threads, minutes,
/// mem_mb}]}. `minutes` is null until all stages of the task were measured, `mem_mb` also unless all declare their memory. Throws
/// Error if the store cannot be used.
Value plan_tasks(const Pipeline& pipeline, const std::string& until, const Store& store, int threads);

}  // namespace fresco::host
