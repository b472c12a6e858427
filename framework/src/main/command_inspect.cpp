#include "main/commands.h"

#include "plugins/plugin_search.h"
#include "run/commands_inspect.h"

#include <iostream>

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

}  // namespace

void add_inspect_commands(CLI::App& app, int& exit_code)
{
    const auto arguments = std::make_shared<InspectArguments>();
    const auto add = [&](const char* name, const char* help, int (*action)(const InspectArguments&, const Catalog&))
    {
        CLI::App* command = app.add_subcommand(name, help);
        command->callback([arguments, action, &exit_code] { exit_code = action(*arguments, load_catalog()); });
        return command;
    };

    CLI::App* check = add("check", "Report every problem of a pipeline without running it",
                          [](const InspectArguments& given, const Catalog& catalog)
                          { return write_check(load(given, catalog), given.json, given.json ? std::cout : std::cerr); });
    arguments->pipeline.add_to(*check);
    check->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* stages = add("stages", "List the stages and components that plugins provide",
                           [](const InspectArguments& given, const Catalog& catalog)
                           { return write_stages(catalog, given.all, given.json, std::cout); });
    stages->add_flag("--all", arguments->all,
                     "Also show where each comes from, and why plugins cannot be loaded or are not built");
    stages->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* describe = add("describe", "Show the ports, options, defaults, ranges and help of a stage or component",
                             [](const InspectArguments& given, const Catalog& catalog)
                             { return write_description(catalog, given.type, given.json, std::cout, std::cerr); });
    describe->add_option("type", arguments->type, "Type, as in a pipeline file: mesh.decimate")->required();
    describe->add_flag("--json", arguments->json, "Print JSON");

    CLI::App* graph = add("graph", "Print the pipeline's graph in the DOT language",
                          [](const InspectArguments& given, const Catalog& catalog)
                          { return write_graph(load(given, catalog), std::cout, std::cerr); });
    arguments->pipeline.add_to(*graph);

    add("schema", "Print a JSON Schema of pipeline files, for editors",
        [](const InspectArguments&, const Catalog& catalog) { return write_schema(catalog, std::cout); });
}

}  // namespace fresco::host
