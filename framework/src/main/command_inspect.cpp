#include "base/process.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/schema.h"
#include "plugins/plugin_library.h"
#include "plugins/plugin_search.h"
#include "run/commands_inspect.h"
#include "store/stage_log.h"
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/wording.h>

#include <cstdio>
#include <ranges>
#include <sstream>
#include <unistd.h>

namespace fresco::host
{
namespace
{

struct InspectArguments
{
    PipelineArguments pipeline;
    std::string type;
    bool all = false;
    bool json = false;
};

PipelineResult load(const InspectArguments& arguments, const Catalog& catalog)
{
    return load_pipeline(arguments.pipeline.request(), catalog);
}

/// Output of a command. Texts are folded to the width of the terminal, documents for machines are not.
struct Printed
{
    std::ostringstream out{};
    std::ostringstream errors{};
    std::size_t width = terminal_width(STDOUT_FILENO);

    Printed()
    {
        // Else a text that memory does not suffice for would be cut without a word.
        out.exceptions(std::ios::badbit);
        errors.exceptions(std::ios::badbit);
    }
    void print(bool is_text) const
    {
        constexpr std::size_t indent = 4;
        std::fputs((is_text ? folded(out.str(), width, indent) : out.str()).c_str(), stdout);
        std::istringstream said(errors.str());
        for (std::string line; std::getline(said, line);)
            print_message(line);
    }
};

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
        const auto names = std::views::keys(logs);
        throw MissingInput(arguments.file + ": no stage '" + arguments.stage + "' has run" +
                           suggestion(arguments.stage, {names.begin(), names.end()}));
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

void add_inspect_commands(CLI::App& app, int& exit_code)
{
    const auto arguments = std::make_shared<InspectArguments>();
    const auto add =
        [&](const char* name, const char* help, bool is_text, int (*action)(const InspectArguments&, const Catalog&, Printed&))
    {
        CLI::App* command = app.add_subcommand(name, help);
        command->callback(
            [arguments, action, is_text, &exit_code]
            {
                Printed printed;
                warn_of_plugin_folders();
                Catalog catalog = load_catalog();
                if (arguments->all)
                    open_all(catalog);
                exit_code = action(*arguments, catalog, printed);
                printed.print(is_text && !arguments->json);
            });
        return command;
    };

    CLI::App* check = add("check", "Report every problem of a pipeline without running it", true,
                          [](const InspectArguments& given, const Catalog& catalog, Printed& to)
                          { return write_check(load(given, catalog), given.json, given.json ? to.out : to.errors); });
    arguments->pipeline.add_to(*check);
    check->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* stages = add("stages", "List the stages and components that plugins provide", true,
                           [](const InspectArguments& given, const Catalog& catalog, Printed& to)
                           { return write_stages(catalog, given.all, given.json, to.width, to.out); });
    stages->add_flag("--all", arguments->all,
                     "Also show where each comes from, and why plugins cannot be loaded or are not built");
    stages->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* describe = add(
        "describe", "Show the ports, options, defaults, ranges and help of a stage or component, or how a file was made", true,
        [](const InspectArguments& given, const Catalog& catalog, Printed& to)
        {
            if (const TypeDescription* reader = origin_reader(catalog, given.type))
                write_file_origin(*reader, given.type, given.json, to.width, to.out);
            else
                return write_description(catalog, given.type, given.json, to.width, to.out, to.errors);
            return 0;
        });
    describe->add_option("type", arguments->type, "Type, as in a pipeline file, or an exported file")->required();
    describe->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* schema = add("schema", "Print where the JSON Schema of pipeline files is installed, for editors", false,
                           [](const InspectArguments& given, const Catalog& catalog, Printed& to)
                           {
                               const auto file = installed_schema();
                               if (!given.json && !std::filesystem::exists(file))
                                   throw MissingInput(file.string() +
                                                      " is missing: ./bootstrap build makes it; fresco schema --json prints one");
                               to.out << (given.json ? to_json(pipeline_schema(catalog), 2) : file.string()) << '\n';
                               return 0;
                           });
    schema->add_flag("--json", arguments->json, "Print a schema instead, with the types of your own plugins");

    CLI::App* log = app.add_subcommand("log", "Show what a stage printed when its result was made");
    const auto of_log = std::make_shared<LogArguments>();
    log->add_option("file", of_log->file, "Pipeline file (YAML)")->required();
    log->add_option("stage", of_log->stage, "Stage, as in the file; of a matrix also NAME@VALUE")->required();
    of_log->places.add_store_to(*log);
    log->callback([of_log, &exit_code] { exit_code = print_log(*of_log); });
}

std::filesystem::path installed_schema()
{
    return own_program().parent_path().parent_path() / "share/fresco/pipeline.schema.json";
}

}  // namespace fresco::host
