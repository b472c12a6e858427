#pragma once

#include "run/task_table.h"

#include <filesystem>
#include <string>

namespace fresco::host
{

/// The Snakefile of a folder of tasks, to lie in it: a rule per group, a job per task, and one that collects the results. Reads
/// the table when Snakemake does; Snakemake 7 and later. `program`: fresco, absolute. Throws Error if the folder
/// or the program has a script_problem.
std::string snakefile(const TaskTable& head, const std::filesystem::path& folder, const std::filesystem::path& program);

}  // namespace fresco::host
