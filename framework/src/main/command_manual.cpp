#include "base/machine.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/reference.h"
#include "plugins/plugin_search.h"

#include <cstdio>
#include <string>

/// \file The manual page for `man fresco`, from the declarations that `--help` shows. The build writes it for the installation.

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
    for (const auto& [file, difference] : differences)
        print_message("error: " + (std::filesystem::path(given.folder) / file).string() + ": " + difference);
    if (!differences.empty())
        print_message("regenerate the pages: fresco reference " + given.folder);
    return differences.empty() ? 0 : exit_differs;
}

/// Text for troff: no character of it is a request or an escape.
std::string troff(const std::string& text)
{
    std::string result;
    bool line_begins = true;
    for (const char letter : text)
    {
        if (line_begins && (letter == '.' || letter == '\''))
            result += "\\&";
        line_begins = letter == '\n';
        result += letter == '\\' ? std::string("\\e") : letter == '-' ? std::string("\\-") : std::string(1, letter);
    }
    return result;
}

std::string entry(const std::string& term, const std::string& text)
{
    return ".TP\n\\fB" + troff(term) + "\\fR\n" + troff(text) + "\n";
}

/// The command's own section, then those of the commands below it.
std::string sections(const CLI::App& command, const std::string& name)
{
    const CLI::Formatter formatter;
    std::string usage = name;
    std::string options;
    for (const CLI::Option* option : command.get_options([](const CLI::Option* each) { return !each->get_group().empty(); }))
    {
        if (option->check_lname("help"))
            continue;
        if (option->get_positional())
            usage += " " + formatter.make_option_name(option, true);
        options += entry(formatter.make_option_name(option, option->get_positional()) + formatter.make_option_opts(option),
                         option->get_description());
    }
    const auto below = command.get_subcommands([](const CLI::App* each) { return !each->get_group().empty(); });
    std::string result;
    if (below.empty())
        result = ".SS " + troff(usage) + "\n" + troff(command.get_description()) + "\n" + options;
    for (const CLI::App* each : below)
        result += sections(*each, name + " " + each->get_name());
    return result;
}

std::string program_sections()
{
    std::string result;
    for (const auto& [name, lines] : program_helps())
    {
        result += ".SS " + troff("fresco " + name) + "\n.nf\n";
        for (const std::string& line : lines)
            result += troff(line) + "\n";
        result += ".fi\n";
    }
    return result;
}

std::string manual(const CLI::App& app)
{
    return ".TH FRESCO 1 \"\" \"fresco " + program_version() +
           "\" \"User Commands\"\n.SH NAME\nfresco \\- paint scanned rooms\n" +
           ".SH SYNOPSIS\n.B fresco\n.I COMMAND\n[\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" + troff(app.get_description()) +
           "\n.PP\n" + troff("fresco COMMAND --help prints what is said of a command below.") + "\n.SH COMMANDS\n" +
           sections(app, app.get_name()) + program_sections() + ".SH EXIT STATUS\n" + troff(app.get_footer()) + "\n";
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

void add_manual_command(CLI::App& app)
{
    app.add_subcommand("internal-manual", "Print the manual page; the build calls this")
        ->group("")
        ->callback([&app] { std::fputs(manual(app).c_str(), stdout); });
}

}  // namespace fresco::host
