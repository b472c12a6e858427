#include "base/machine.h"
#include "base/text.h"
#include "main/commands.h"
#include "pipeline/reference.h"
#include "plugins/plugin_search.h"

#include <cstdio>
#include <fmt/ranges.h>
#include <string>

/// \file The manual page for `man fresco`, from the declarations that `--help` shows. The build writes it for the installation.

namespace fresco::host
{

namespace
{

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

/// A command's help as it is printed.
std::string section(const std::string& name, const std::string& help)
{
    return ".SS " + troff("fresco " + name) + "\n.nf\n" + troff(help) + "\n.fi\n";
}

/// The sections of the commands below one.
std::string sections(const CLI::App& command, const std::string& above)
{
    std::string result;
    for (const CLI::App* each : command.get_subcommands([](const CLI::App* app) { return !app->get_group().empty(); }))
    {
        const std::string name = above + each->get_name();
        const std::string below = sections(*each, name + " ");
        const std::string help = each->help();
        // The exit codes stand once at the end.
        result += below.empty() ? section(name, help.substr(0, help.find("\nExit codes: "))) : below;
    }
    return result;
}

std::string program_sections()
{
    std::string result;
    for (const auto& [name, lines] : program_helps())
        result += section(name, fmt::format("{}", fmt::join(lines, "\n")));
    return result;
}

std::string manual(const CLI::App& app)
{
    return ".TH FRESCO 1 \"\" \"fresco " + program_version() +
           "\" \"User Commands\"\n.SH NAME\nfresco \\- paint scanned rooms\n" +
           ".SH SYNOPSIS\n.B fresco\n.I COMMAND\n[\\fIOPTIONS\\fR]\n.SH DESCRIPTION\n" + troff(app.get_description()) +
           "\n.PP\n" + troff("fresco COMMAND --help prints what is said of a command below.") + "\n.SH COMMANDS\n" +
           sections(app, "") + program_sections() + ".SH EXIT STATUS\n" + troff(app.get_footer()) + "\n";
}

}  // namespace

void add_reference_command(CLI::App& app, int& exit_code)
{
    const auto folder = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand("reference", "Write a Markdown page for every stage and component");
    command->add_option("folder", *folder, "Folder for the pages")->required();
    command->callback(
        [folder, &exit_code]
        {
            for (const std::string& file : write_reference(reference_pages(load_catalog()), *folder))
                print_line(file);
            exit_code = 0;
        });
}

void add_manual_command(CLI::App& app)
{
    app.add_subcommand("internal-manual", "Print the manual page; the build calls this")
        ->group("")
        ->callback([&app] { std::fputs(manual(app).c_str(), stdout); });
}

}  // namespace fresco::host
