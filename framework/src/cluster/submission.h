#pragma once

#include "cluster/slurm.h"
#include "run/task_table.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// \file What was submitted of a folder of tasks, below it:
///   slurm/settings.json      what all its jobs have in common
///   slurm/lock               held while something is submitted
///   slurm/wave-000/          arrays that were submitted together
///     wave.json              {"round": 1, "arrays": [{"name", "minutes", "memory_mb"}]}, written last
///     submit.sh, jobs        the script that submitted them; a line "ARRAY ID" for each it has submitted
///     ARRAY.sbatch, .list    an array's job, and its elements
///     ARRAY.INDEX.log        a link to the log of the element's task
///   logs/TASK.log            what a task printed, in all its attempts

namespace fresco::host
{

/// An element that was submitted.
struct Attempt
{
    ElementId element;
    std::size_t round = 0;
    JobLimits limits;
};

class Submission
{
  public:
    static bool is_at(const std::filesystem::path& folder);
    /// Begins one, or changes what its next jobs have in common. Throws Error if the file cannot be written.
    static void configure(const std::filesystem::path& folder, const SlurmSettings& settings);
    /// Throws MissingInput if the folder has none, Error naming a damaged file.
    explicit Submission(std::filesystem::path folder);

    const SlurmSettings& settings() const { return settings_; }
    std::size_t next_wave() const { return waves_.empty() ? 0 : waves_.back().number + 1; }
    /// Counts the times that a user asked for what was missing; 0 before the first.
    std::size_t round() const { return waves_.empty() ? 0 : waves_.back().round; }

    /// By task: its attempts, the last one last. An array whose submission was cut off is looked for in `queue` by its name.
    std::map<std::size_t, std::vector<Attempt>> attempts(const SlurmQueue& queue) const;

    /// Removes the folders of waves of which nothing was submitted, and writes this one. Throws Error.
    void write(const Wave& wave, std::size_t round);

  private:
    struct WrittenArray
    {
        JobArray array;   ///< Without what it waited for.
        std::string job;  ///< Empty: not submitted, or its id was not written.
    };
    struct WrittenWave
    {
        std::size_t number = 0;
        std::size_t round = 0;
        bool begun = false;
        std::vector<WrittenArray> arrays;
    };

    static WrittenWave read_wave(const std::filesystem::path& folder);

    std::filesystem::path folder_;
    SlurmSettings settings_;
    std::vector<WrittenWave> waves_;
};

/// "data,picture@kitchen,waves"; of a task with several combinations "data,picture@kitchen.17", by its number.
std::string task_name(const TaskTable& table, const Task& task);

/// What a task printed in its last attempt.
struct TaskLog
{
    std::filesystem::path file;
    std::string job;  ///< "123_4"; empty: it never began.
    std::string text;

    bool memory_ran_out() const;
    bool time_ran_out() const;
};
TaskLog last_log(const std::filesystem::path& folder, const std::string& task_name);

/// The Snakefile of a folder of tasks, to lie in it: a rule per group, a job per task, and one that collects the results. Reads
/// the table when Snakemake does; Snakemake 7 and later. `program`: fresco, absolute. Throws Error if the folder
/// or the program has a script_problem.
std::string snakefile(const TaskTable& head, const std::filesystem::path& folder, const std::filesystem::path& program);

}  // namespace fresco::host
