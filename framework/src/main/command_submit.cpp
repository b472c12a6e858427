#include "base/common.h"
#include "base/process.h"
#include "base/text.h"
#include "cluster/submission.h"
#include "cluster/submit.h"
#include "main/commands.h"
#include "run/task_table.h"
#include <fresco/file_access.h>
#include <fresco/files_io.h>

#include <fmt/format.h>
#include <random>

namespace fresco::host
{
namespace
{

struct SubmitArguments
{
    TableArguments table;
    SlurmSettings settings;
    bool dry_run = false;
    bool continued = false;
};

/// Unlike those of all other folders: jobs are found by it.
std::string new_run_name()
{
    std::random_device random;
    return fmt::format("fresco-{:08x}", random());
}

void tell(const SubmitOutcome& outcome, const SubmitRequest& request, const TaskTable& table)
{
    const fs::path script = request.folder / wave_folder(outcome.wave.number) / "submit.sh";
    if (outcome.wave.arrays.empty())
        fmt::print("nothing to submit: ");
    else
        fmt::print("{} {} in {}: ", request.dry_run ? "would submit" : "submitted", counted(outcome.missing.tasks.size(), "task"),
                   counted(outcome.wave.arrays.size(), "array"));
    fmt::print("{} of {} done, {} in the queue before, {} left for later\n", outcome.done, table.task_count,
               outcome.missing.queued.size(), outcome.missing.left);
    if (outcome.missing.blocked > 0)
        fmt::print("{} failed or need{} what failed: fresco status {}\n", counted(outcome.missing.blocked, "task"),
                   outcome.missing.blocked == 1 ? "s" : "", shell_word(path_text(request.folder)));
    using Kind = TextTable::Kind;
    TextTable arrays({{"array", Kind::name},
                      {"tasks", Kind::number},
                      {"time limit", Kind::number},
                      {"memory", Kind::number},
                      {"cores", Kind::number},
                      {"", Kind::figure}});
    constexpr std::size_t most_shown = 20;
    for (std::size_t i = 0; i < std::min(most_shown, outcome.wave.arrays.size()); ++i)
    {
        const JobArray& array = outcome.wave.arrays[i];
        arrays.add({array.name, std::to_string(array.elements.size()), duration_text(60.0 * array.limits.minutes),
                    size_text(array.limits.memory_mb), std::to_string(array.limits.threads), array.limits.gpu ? "GPU" : ""});
    }
    if (request.dry_run && !outcome.wave.arrays.empty())
        fmt::print("{}{}{}\n", arrays.text(terminal_width(STDOUT_FILENO)),
                   outcome.wave.arrays.size() > most_shown
                       ? fmt::format("… and {} more arrays\n", outcome.wave.arrays.size() - most_shown)
                       : "",
                   path_text(script));
}

/// Keeps what was said before where nothing else is said now.
void configure(const fs::path& folder, const SlurmSettings& said)
{
    SlurmSettings settings;
    if (Submission::is_at(folder))
        settings = Submission(folder).settings();
    else
        settings.run = new_run_name();
    settings.program = own_program();
    if (!said.partition.empty())
        settings.partition = said.partition;
    if (!said.gpu_partition.empty())
        settings.gpu_partition = said.gpu_partition;
    if (said.max_queued > 0)
        settings.max_queued = said.max_queued;
    Submission::configure(folder, settings);
}

int submit(const SubmitArguments& arguments)
{
    SubmitRequest request{fs::absolute(arguments.table.pipeline.file).lexically_normal(), arguments.dry_run, arguments.continued};
    const bool begins = !fs::is_directory(request.folder);
    if (begins)
        request.folder = guarded_task_folder(arguments.table.folder);
    if (const std::string problem = script_problem(arguments.settings, request.folder); !problem.empty())
        throw UsageError("error: " + problem);
    if (!begins)
    {
        if (const std::string option = arguments.table.set_option(); !option.empty())
            throw UsageError(fmt::format("{}: error: only for a pipeline file; the tasks in {} are made already", option,
                                         path_text(request.folder)));
    }
    else if (const int code = write_tasks(arguments.table); code != 0)
        return code;
    if (!arguments.continued)
        configure(request.folder, arguments.settings);
    const auto loaded = load_tasks(request.folder);
    if (!loaded->result.problems.empty())
        return loaded->result.exit_code();
    const TaskTable head = read_task_head(request.folder);
    if (const std::string changed = changed_plugin(head, loaded->result.pipeline); !changed.empty())
    {
        print_message("error: " + changed);
        return 4;
    }
    const SubmitOutcome outcome = submit_missing(request, loaded->result.pipeline);
    if (!outcome.silence.empty())
        print_message("Slurm does not answer here, so its queue is taken to be empty and its limits to be the defaults: " +
                      outcome.silence);
    tell(outcome, request, head);
    if (outcome.script.exit_code > 0)
    {
        print_message("error: submitting ended early; run the same command again to go on:" + outcome.script.quoted_output());
        return 1;
    }
    return 0;
}

int export_snakemake(const TableArguments& arguments)
{
    const fs::path folder = guarded_task_folder(arguments.folder);
    if (const std::string problem = script_problem("--folder", folder.string()); !problem.empty())
        throw UsageError("error: " + problem);
    const fs::path file = folder / "Snakefile";
    if (path_status(file))
        throw UsageError("error: " + file.string() + ": already exists; nothing was written: choose another --folder");
    if (const int code = write_tasks(arguments); code != 0)
        return code;
    write_file(file, snakefile(read_task_head(folder), folder, own_program()));
    print_line(path_text(file));
    return 0;
}

}  // namespace

void TableArguments::add_to(CLI::App& command, const std::string& file_help)
{
    pipeline.add_to(command);
    places.add_store_to(command);
    places.add_out_to(command);
    pipeline.add_until_to(command);
    command.add_option("--folder", folder, "Folder for the tasks")->capture_default_str();
    command.add_option("--pack", pack_minutes, "Estimated minutes of work to put into one task; 0: one combination each")
        ->check(CLI::Range(0.0, 1e6))
        ->capture_default_str();
    command.add_option("--cores", cores, "Processor cores of each task")->check(CLI::Range(1, 4096))->capture_default_str();
    for (const char* name : {"--set", "--without", "--preview", "--store", "--out", "--until", "--folder", "--pack", "--cores"})
        options_.push_back(command.get_option(name));
    command.get_option("pipeline")->description(file_help);
}

fs::path guarded_task_folder(const fs::path& folder)
{
    const fs::path whole = fs::absolute(folder).lexically_normal();
    forbid_links_below(whole, "remove it, or choose another folder");
    return whole;
}

std::string TableArguments::set_option() const
{
    for (const CLI::Option* option : options_)
        if (option->count() > 0)
            return option->get_name();
    return "";
}

TaskTable planned_tasks(const PipelineArguments& arguments, const Pipeline& pipeline, const PlaceArguments& places,
                        double pack_minutes, int cores)
{
    constexpr double seconds_per_minute = 60;
    return plan_tasks(arguments.request(), pipeline, places.store_folder(), places.out_folder(),
                      {pack_minutes * seconds_per_minute, cores});
}

int write_tasks(const TableArguments& arguments)
{
    const auto loaded = load_and_report(arguments.pipeline.request());
    if (!loaded->result.problems.empty())
        return loaded->result.exit_code();
    arguments.places.check();
    write_task_table(
        planned_tasks(arguments.pipeline, loaded->result.pipeline, arguments.places, arguments.pack_minutes, arguments.cores),
        guarded_task_folder(arguments.folder));
    return 0;
}

std::unique_ptr<LoadedPipeline> load_tasks(const fs::path& folder)
{
    return load_and_report(read_task_head(folder).pipeline);
}

void add_submit_commands(CLI::App& app, int& exit_code)
{
    CLI::App* submit_command = app.add_subcommand("submit", "Queue a pipeline on a cluster");
    submit_command->require_subcommand(1);
    CLI::App* slurm = submit_command->add_subcommand("slurm", "As Slurm job arrays; of a folder only what is missing");
    const auto arguments = std::make_shared<SubmitArguments>();
    arguments->table.add_to(*slurm, "Pipeline file (YAML), or the folder of an earlier submission");
    slurm->add_option("--partition", arguments->settings.partition, "Partition of the jobs (default: the scheduler's)");
    slurm->add_option("--gpu-partition", arguments->settings.gpu_partition,
                      "Partition of the jobs that need a GPU (default: --partition)");
    slurm
        ->add_option("--max-queued", arguments->settings.max_queued,
                     "Jobs to have in the queue at a time, the rest in later waves (default: half of Slurm's MaxJobCount)")
        ->check(CLI::Range(3, 100'000'000));
    slurm->add_flag("--dry-run", arguments->dry_run, "Write the scripts, submit nothing");
    slurm->add_flag("--continue", arguments->continued)->group("");
    slurm->callback([arguments, &exit_code] { exit_code = submit(*arguments); });

    CLI::App* export_command = app.add_subcommand("export", "Write a pipeline for another program to run");
    export_command->require_subcommand(1);
    CLI::App* snakemake = export_command->add_subcommand("snakemake", "As a Snakefile, for Snakemake 7 and later");
    const auto table = std::make_shared<TableArguments>();
    table->add_to(*snakemake, "Pipeline file (YAML)");
    snakemake->callback([table, &exit_code] { exit_code = export_snakemake(*table); });
}

}  // namespace fresco::host
