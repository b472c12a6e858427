#include "main/commands.h"

#include "plugins/plugin_library.h"
#include "report/report.h"
#include "run/commands_inspect.h"
#include "worker/worker.h"

#include <array>

namespace fresco::host
{

void add_internal_commands(CLI::App& app, int& exit_code)
{
    const auto file = std::make_shared<std::string>();
    const auto files = std::make_shared<std::vector<std::string>>();
    CLI::App* open = app.add_subcommand("internal-open", "Open plugins; the host calls this")->group("");
    open->add_option("libraries", *files)->required();
    open->callback([files] { internal_open(*files); });
    CLI::App* run = app.add_subcommand("internal-run", "Run one stage from store paths; the host calls this")->group("");
    run->add_option("request", *file)->required();
    run->callback([file] { internal_run(*file); });
    const auto words = std::make_shared<std::array<std::string, 3>>();
    CLI::App* origin = app.add_subcommand("internal-origin", "Read how a file was made; the host calls this")->group("");
    origin->add_option("library", (*words)[0])->required();
    origin->add_option("type", (*words)[1])->required();
    origin->add_option("file", (*words)[2])->required();
    origin->callback([words, &exit_code] { exit_code = internal_origin((*words)[0], (*words)[1], (*words)[2]); });
    CLI::App* page = app.add_subcommand("internal-page", "Write a page of results; the host calls this")->group("");
    page->add_option("request", *file)->required();
    page->callback([file, &exit_code] { exit_code = internal_page(*file); });
}

}  // namespace fresco::host
