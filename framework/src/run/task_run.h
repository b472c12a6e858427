#pragma once

#include "run/run_state.h"
#include "run/task_table.h"

#include <filesystem>
#include <string>

/// \file One task of a table, run by a process of its own.

namespace fresco::host
{

/// Loads no more of the pipeline than the combinations that the task is of.
PipelineRequest task_request(const TaskTable& head, const Task& task);

/// What is wrong with the plugins that `pipeline` uses: one whose bytes are not those that the table was made with. Empty:
/// nothing.
std::string changed_plugin(const TaskTable& head, const Pipeline& pipeline);

/// The task's stages. Where another's result is missing, the text names the task that makes it. `folder` has the table; `head`
/// must outlive the result.
RunPart task_part(const std::filesystem::path& folder, const TaskTable& head, const Task& task);

}  // namespace fresco::host
