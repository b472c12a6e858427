#include "base/text_layout.h"
#include "main/commands.h"

#include "pipeline/reference.h"
#include "plugins/plugin_search.h"

namespace fresco::host
{
namespace
{

constexpr int exit_differs = 1;

struct ReferenceArguments
{
    std::string folder;
    bool check = false;
};

int run(const ReferenceArguments& given)
{
    const auto pages = reference_pages(load_catalog());
    if (!given.check)
    {
        for (const std::string& file : write_reference(pages, given.folder))
            print_line(file);
        return 0;
    }
    const auto differences = reference_differences(pages, given.folder);
    for (const std::string& line : differences)
        print_message("error: " + line);
    if (!differences.empty())
        print_message("regenerate the pages: fresco reference " + given.folder);
    return differences.empty() ? 0 : exit_differs;
}

}  // namespace

void add_reference_command(CLI::App& app, int& exit_code)
{
    const auto arguments = std::make_shared<ReferenceArguments>();
    CLI::App* command = app.add_subcommand("reference", "Write a Markdown page for every stage and component");
    command->add_option("folder", arguments->folder, "Folder for the pages")->required();
    command->add_flag("--check", arguments->check, "Write nothing; name the pages that differ and end with 1 if there are any");
    command->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace fresco::host
