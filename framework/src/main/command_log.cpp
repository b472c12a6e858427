#include "main/commands.h"

#include "base/text.h"
#include "store/stage_log.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <cstdio>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct LogArguments
{
    std::string file;
    std::string stage;
    PlaceArguments places;
};

int print_log(const LogArguments& arguments)
{
    const Store store = arguments.places.existing_store();
    if (!std::filesystem::exists(arguments.file))
        throw MissingInput(arguments.file + ": no such file");
    const auto logs = stage_logs(store, std::filesystem::absolute(arguments.file));
    if (logs.empty())
        throw MissingInput(arguments.file + ": none of its stages has run with the store " + store.root().string() +
                           "; set its folder with --store");
    const auto found = logs.find(arguments.stage);
    if (found == logs.end())
    {
        std::vector<std::string> names;
        for (const auto& [name, log] : logs)
            names.push_back(name);
        throw MissingInput(arguments.file + ": no stage '" + arguments.stage + "' has run" + suggestion(arguments.stage, names));
    }
    if (!std::filesystem::exists(found->second))
        throw MissingInput("the log of the stage '" + arguments.stage + "' was removed with its result");
    const std::string text = read_text_file(found->second);
    // A file or a pipe gets what the stage printed, colors included.
    std::fputs((isatty(STDOUT_FILENO) != 0 ? harmless(text, LineEnds::all) : text).c_str(), stdout);
    if (text.empty())
        std::fputs("the stage printed nothing\n", stderr);
    return 0;
}

}  // namespace

void add_log_command(CLI::App& app, int& exit_code)
{
    CLI::App* command = app.add_subcommand("log", "Show what a stage printed when its result was made");
    const auto arguments = std::make_shared<LogArguments>();
    command->add_option("file", arguments->file, "Pipeline file (YAML)")->required();
    command->add_option("stage", arguments->stage, "Stage, as in the file; of a matrix also texture@waves")->required();
    arguments->places.add_store_to(*command);
    command->callback([arguments, &exit_code] { exit_code = print_log(*arguments); });
}

}  // namespace fresco::host
