#include "main/commands.h"

#include "plugins/plugin_probe.h"
#include "report/report.h"
#include "report/sweep_summary.h"
#include "worker/worker.h"

namespace fresco::host
{

void add_internal_commands(CLI::App& app, int& exit_code)
{
    const auto file = std::make_shared<std::string>();
    CLI::App* probe = app.add_subcommand("internal-probe", "Describe one plugin; the host calls this")->group("");
    probe->add_option("library", *file)->required();
    probe->callback([file, &exit_code] { exit_code = internal_probe(*file); });
    CLI::App* run = app.add_subcommand("internal-run", "Run one stage from store paths; the host calls this")->group("");
    run->add_option("request", *file)->required();
    run->callback([file] { internal_run(*file); });
    CLI::App* sweep = app.add_subcommand("internal-sweep", "Write the page of a matrix; the host calls this")->group("");
    sweep->add_option("request", *file)->required();
    sweep->callback([file, &exit_code] { exit_code = internal_sweep(*file); });
    CLI::App* report = app.add_subcommand("internal-report", "Write the report of a run; the host calls this")->group("");
    report->add_option("request", *file)->required();
    report->callback([file, &exit_code] { exit_code = internal_report(*file); });
}

}  // namespace fresco::host
