#include "base/common.h"
#include "base/text.h"
#include "main/commands.h"
#include <fresco/file_access.h>

namespace fresco::host
{

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
    for (const char* name : {"--set", "--preview", "--store", "--out", "--until", "--folder", "--pack", "--cores"})
        options_.push_back(command.get_option(name));
    command.get_option("pipeline")->description(file_help);
}

fs::path guarded_task_folder(const fs::path& folder)
{
    const fs::path whole = fs::absolute(folder).lexically_normal();
    forbid_links_below(whole, "choose another folder");
    return whole;
}

fs::path TableArguments::folder_path() const
{
    return guarded_task_folder(folder);
}

std::string TableArguments::set_option() const
{
    for (const CLI::Option* option : options_)
        if (option->count() > 0)
            return option->get_name();
    return "";
}

int write_tasks(const TableArguments& arguments)
{
    const PipelineRequest request = arguments.pipeline.request();
    const auto loaded = load_and_report(request);
    if (!loaded->result.problems.empty())
        return loaded->result.exit_code();
    arguments.places.check();
    constexpr double seconds_per_minute = 60;
    write_task_table(plan_tasks(request, loaded->result.pipeline, arguments.places.store_folder(), arguments.places.out_folder(),
                                {arguments.pack_minutes * seconds_per_minute, arguments.cores}),
                     arguments.folder_path());
    return 0;
}

std::unique_ptr<LoadedPipeline> load_tasks(const fs::path& folder)
{
    return load_and_report(read_task_head(folder).pipeline);
}

}  // namespace fresco::host
