#include "main/commands.h"

#include "base/machine.h"
#include "base/text.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fcntl.h>
#include <iostream>
#include <iterator>
#include <new>
#include <sstream>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

namespace
{

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;
constexpr int exit_missing_input = 3;
constexpr int exit_bug = 70;

constexpr const char* no_memory =
    "error: there is not enough memory: close other programs, or raise the limit (ulimit -d, ulimit -v)\n";

using fresco::host::print_message;

/// Help in the width of the terminal. Where that is narrow, what an option does stands below it.
class FoldedHelp final : public CLI::Formatter
{
  public:
    FoldedHelp()
    {
        constexpr std::size_t narrow = 72;
        constexpr std::size_t below = 6;
        if (width_ < narrow)
            column_width(below);
    }

    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override
    {
        std::string result;
        std::istringstream lines(Formatter::make_help(app, std::move(name), mode));
        for (std::string line; std::getline(lines, line);)
        {
            const std::size_t first = std::min(line.find_first_not_of(' '), line.size());
            const std::size_t column = get_column_width();
            // An option or a command with what it does beside it.
            const bool has_both = first > 0 && first < column && line.size() > column && line[column - 1] == ' ';
            result += fresco::host::folded(line, width_, has_both ? column - first : line.starts_with("Usage") ? 4 : 0) + "\n";
        }
        std::vector<std::string> programs = fresco::host::program_commands();
        for (const CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; }))
            std::erase(programs, command->get_name());
        if (app->get_parent() == nullptr && !programs.empty())
            result += fresco::host::folded("\nPrograms, as commands: " + fresco::join(programs, ", ") + "\n", width_, 4);
        return result;
    }

  private:
    // A file or a pipe gets the usual width.
    std::size_t width_ = fresco::host::terminal_width(STDOUT_FILENO) == fresco::host::without_end
                             ? 80
                             : fresco::host::terminal_width(STDOUT_FILENO);
};

/// Prints what CLI11 refuses, with the nearest word for one that it does not know; or the help, where it was asked for or a
/// command was left out. The exit code.
int end_parsing(const CLI::App& app, const CLI::ParseError& error)
{
    if (error.get_exit_code() == 0)
        return app.exit(error);
    const CLI::App* command = &app;
    std::string name = app.get_name();
    for (; !command->get_subcommands().empty(); name += " " + command->get_name())
        command = command->get_subcommands().front();
    const std::vector<std::string> unknown = command->remaining();
    const bool wants_command = command->get_require_subcommand_min() > 0;
    if (wants_command && unknown.empty())
    {
        std::cout << app.help();
        return exit_usage;
    }
    std::vector<std::string> options, commands;
    for (const CLI::Option* option : command->get_options())
        for (const std::string& known : option->get_lnames())
            options.push_back("--" + known);
    for (const CLI::App* each : command->get_subcommands([](const CLI::App* known) { return !known->get_group().empty(); }))
        commands.push_back(each->get_name());
    if (command == &app)
        std::ranges::copy(fresco::host::program_commands(), std::back_inserter(commands));
    std::string text = error.what();
    if (wants_command && !unknown.front().starts_with('-'))
        text = "unknown command '" + unknown.front() + "'" + fresco::suggestion(unknown.front(), commands);
    else if (const auto option = std::ranges::find_if(unknown, [](const auto& word) { return word.starts_with('-'); });
             option != unknown.end())
    {
        const std::string meant = fresco::nearest(option->substr(0, option->find('=')), options);
        text = "unknown option '" + *option + "'" + (meant.empty() ? "" : " (did you mean '" + meant + "'?)");
    }
    print_message("error: " + text + "\n    " + name + " --help lists what it accepts");
    return exit_usage;
}

int failed(const std::string& text, int exit_code)
{
    print_message(text);
    return exit_code;
}

/// A file that the program opens must not become standard input, output or error of somebody who closed his.
void open_closed_streams()
{
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(descriptor, F_GETFD) == -1)
            open("/dev/null", O_RDWR);  // Takes the lowest free number.
}

/// Whether what was printed got lost on a full disk; says so. A reader that has gone away got what it wanted.
bool output_is_lost()
{
    std::cout.flush();
    const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout;
    struct stat target = {};
    if (!failed || fstat(STDOUT_FILENO, &target) != 0 || S_ISFIFO(target.st_mode) || S_ISSOCK(target.st_mode))
        return false;
    print_message("error: standard output could not be written; is the disk full?");
    return true;
}

int run_command_line(int argc, char** argv)
{
    CLI::App app("fresco paints scanned rooms. It runs pipelines of stages, which are declared in YAML and loaded from shared "
                 "libraries.",
                 "fresco");
    app.formatter(std::make_shared<FoldedHelp>());
    app.require_subcommand(1);
    app.set_version_flag("--version", fresco::host::program_version());
    app.footer(
        "Exit codes: 0 done, 1 a stage failed, 2 pipeline or command line invalid, 3 an input is missing, 4 a plugin cannot be "
        "loaded, 70 a bug, 75 interrupted (run again).");
    int exit_code = 0;
    fresco::host::add_new_commands(app, exit_code);
    fresco::host::add_run_command(app, {argv, argv + argc}, exit_code);
    fresco::host::add_plan_command(app, exit_code);
    fresco::host::add_inspect_commands(app, exit_code);
    fresco::host::add_store_command(app, exit_code);
    fresco::host::add_doctor_command(app, exit_code);
    fresco::host::add_reference_command(app, exit_code);
    fresco::host::add_completion_commands(app);
    fresco::host::add_internal_commands(app, exit_code);
    fresco::host::add_manual_command(app);
    app.add_subcommand("version", "Print the version")->callback([] { std::puts(fresco::host::program_version().c_str()); });
    if (argc > 1 && argv[1][0] != '-' && fresco::host::command_named(app, argv[1]) == nullptr)
    {
        fresco::host::run_program_command(argv);
        argc = 2;  // Words behind an unknown command, such as --help, are not looked at.
    }
    try
    {
        app.parse(argc, argv);
    }
    catch (const CLI::ParseError& error)
    {
        return end_parsing(app, error);
    }
    return exit_code;
}

}  // namespace

int main(int argc, char** argv)
{
    // A reader that goes away (`fresco stages | head`) must not leave a run in disorder.
    std::signal(SIGPIPE, SIG_IGN);
    // Beyond `ulimit -f` writing fails with a reason, as on a full disk. Workers inherit this.
    std::signal(SIGXFSZ, SIG_IGN);
    open_closed_streams();
    try
    {
        const int exit_code = run_command_line(argc, argv);
        return output_is_lost() && exit_code == 0 ? exit_failed : exit_code;
    }
    catch (const fresco::host::UsageError& error)
    {
        return failed(error.what(), exit_usage);
    }
    catch (const fresco::MissingInput& error)
    {
        return failed("error: " + std::string(error.what()), exit_missing_input);
    }
    catch (const std::bad_alloc&)
    {
        std::fputs(no_memory, stderr);
        return exit_failed;
    }
    catch (const fresco::Error& error)
    {
        return failed("error: " + std::string(error.what()), exit_failed);
    }
    catch (const std::system_error& error)
    {
        // The machine refused, which is not a bug: a limit, a removed folder, a path without permission.
        return failed("error: " + std::string(error.what()), exit_failed);
    }
    catch (const std::exception& error)
    {
        return failed("error: unexpected: " + std::string(error.what()) +
                          "\n    This is a bug in fresco; please report it with the command and the pipeline file.",
                      exit_bug);
    }
}
